"""Write flights.json: what the multiple-precision oracle says happens after a rest.

    python -m tests.support.make_flights

It takes a minute. The cam is the oracle's own, made of three circles. Rows are kind, angle (rad,
counted on from turn to turn) and incoming rate (m/rad), with 30 digits; the last hops of a chatter,
slower than SLOW, are left out.
"""

import json
from pathlib import Path

from mpmath import mp, mpf

from tests.support.oracle import ArcsCam, Oracle

CHAPTER = {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8}
CASES = {
    "long transient": (358.0, 60, {}),
    "damped, with weight and preload": (
        450.0, 30, {"damping": 6.0, "gravity": 9.81, "preload": 20.0, "restitution": 0.7},
    ),
    "overdamped": (500.0, 12, {"damping": 120.0}),
    "complete chatter": (190.0, 3, {}),
}  # fmt: skip
SLOW = 1e-4  # m/rad


def flights(rpm: float, turns: int, changes: dict) -> dict:
    """The case and its events from rest at theta = 0."""
    oracle = Oracle(ArcsCam(), **{**CHAPTER, **changes}, rpm=rpm, digits=100)
    with mp.workdps(150):
        omega, turn = mpf(rpm) * mp.pi / 30, 2 * mp.pi
        rows = [
            (event.kind, mp.nstr(event.theta + turn * event.turn, 30), mp.nstr(u, 30))
            for event in oracle.run(turns=turns)
            for u in [(event.u_minus or 0) / omega]
            if event.kind != "impact" or abs(u) >= SLOW
        ]
    return {"rpm": rpm, "turns": turns, "changes": changes, "events": rows}


if __name__ == "__main__":
    lines = [f"{json.dumps(name)}: {json.dumps(flights(*case))}" for name, case in CASES.items()]
    Path(__file__).with_name("flights.json").write_text("{" + ",\n".join(lines) + "}\n")
