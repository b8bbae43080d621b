"""Stored values of the rows of extreme cases, made by the multiple-precision oracle alone.

    python tests/bench/make_rows.py

writes camcli/analysis/bench/reference/stability.json: landings and departures of heavily damped
followers, the hops just above the first detachment, and starts that graze the cam.
"""

from __future__ import annotations

from math import pi
from typing import Any

from make_reference import ARCS, CHAPTER, CUT, case, digits, final, oracle_cam, write  # beside it
from mpmath import mp, mpf

from tests import oracle
from tests.oracle import Flight, Oracle

HEAVY = {
    "6.7e3 at 115": (6.7e3, 115.0),
    "4.1e4 at 700": (4.1e4, 700.0),
    "1e9 at 115": (1e9, 115.0),
    "1e12 at 115": (1e12, 115.0),
}
TURNS = 2
WEAK = 114.98  # rpm: hops near b just above the first detachment


def coarse(self) -> mpf:
    """Cells of the turn alone: the fast decay is over at once, its cell is bisected."""
    return 2 * mp.pi / self.omega / oracle.CELLS_PER_TURN


def heavy(b: float, rpm: float) -> dict[str, Any]:
    """Landings after a flight, departures, and the height at the end, with heavy damping."""
    own = Flight._width
    if b > 1e6:
        Flight._width = coarse
    data = case("", rpm, TURNS, damping=b)
    reference = Oracle(oracle_cam(ARCS), rpm=rpm, **data["follower"])
    events = reference.run(turns=TURNS, chatter_cut=mpf(CUT))
    with mp.workdps(80):
        omega, end = mpf(rpm) * mp.pi / 30, 2 * mp.pi * TURNS
        raw = reference._run(mpf(0), end, mpf(CUT), 0, mpf(rpm), reference.r, None, None)
        q, _ = final(reference, omega, TURNS, raw)
    Flight._width = own
    kept = [
        [e.kind, e.turn, digits(e.theta)]
        for before, e in zip([None, *events], events, strict=False)
        if e.kind == "detachment" or (before is not None and before.kind == "detachment")
    ]
    return {"damping": b, "rpm": rpm, "turns": TURNS, "events": kept, "q": digits(q)}


def graze(rpm: float, degrees: float, delta: float, s: float) -> dict[str, float] | None:
    """Start of an undamped flight that is tangent to the cam `s` rad later, raised by delta m."""
    cam, theta = oracle_cam(ARCS), degrees * pi / 180
    with mp.workdps(40):
        omega = mpf(rpm) * mp.pi / 30
        W = mp.sqrt(mpf(CHAPTER["stiffness"]) / mpf(CHAPTER["mass"])) / omega
        c, c1, _ = cam.laws(theta)
        q, w = c + mpf(delta), c1
        q, w = q * mp.cos(W * s) - w / W * mp.sin(W * s), w * mp.cos(W * s) + W * q * mp.sin(W * s)
        if q <= cam.c(theta - s):
            return None
        start = {"theta_deg": (theta - s) * 180 / pi, "q": float(q), "v": float(w * omega)}
    return {"rpm": rpm, "at": theta, **start}


def stability() -> dict[str, Any]:
    """Stored values of the rows of the extreme cases that need some."""
    flights = [
        graze(rpm, degrees, delta, s)
        for rpm in (300.0, 400.0, 700.0)
        for degrees in (150.5, 153.0, 155.0, 158.0)
        for s in (0.2, 0.3, 0.6, 1.0)
        for delta in (-1e-16, 0.0, 1e-16)
    ]
    grazes = [flight for flight in flights if flight is not None]
    values = {name: heavy(*data) for name, data in HEAVY.items()}
    weak = Oracle(oracle_cam(ARCS), rpm=WEAK, **CHAPTER).run(impacts=8)
    hops = [[digits(e.theta), digits(e.u_minus)] for e in weak if e.kind == "impact"]
    more = {"weak": {"rpm": WEAK, "impacts": hops}, "grazes": grazes}
    return {"follower": CHAPTER, "cam": ARCS, "heavy": values, **more}


if __name__ == "__main__":
    write("stability", stability())
