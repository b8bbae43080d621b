"""Contacts of random flights that solve_ivp misses or invents, and ours, judged in ball arithmetic.

    python tests/bench/bench_flights.py [--flights 2000]

Two ways of using solve_ivp fly them too: RK45 with a terminal contact event and nothing else, and
DOP853 as `cam bench precision` uses it. `--ours` leaves them out: a million flights take an hour.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from math import inf, pi
from pathlib import Path

import numpy as np
import scipy.integrate

sys.path.insert(0, str(Path(__file__).parents[2]))

from camcli.analysis.bench.machine import reference
from camcli.analysis.bench.peers import (
    TWO_PI,
    BudgetError,
    Lift,
    PeerMachine,
    PeerState,
    next_landing,
    solve_ivp,
)
from tests.support.random_flights import (
    INVENTED,
    MISSED,
    RIGHT,
    TURNS,
    UNDECIDED,
    Flight,
    landing,
    random_flight,
    verdict,
)

TOLERANCE = 1e-9  # rtol = atol
APART = 1e-3  # rad: a peer's contact further off is another one
SLOWEST = 5.0  # s, for one flight


def plain(lift: Lift, f: Flight) -> float | None:
    """RK45 with a terminal contact event; phase of the contact."""

    lane = f.system.constants(f.rpm, 0.0, 1)

    def rhs(_s, z):
        return z[1], -lane.W2 * z[0] - 2.0 * lane.Z * z[1] - lane.G

    def contact(s, z):
        return z[0] - lift.at(f.theta + s)[0]

    contact.terminal, contact.direction = True, -1  # type: ignore[attr-defined]
    span = (0.0, TURNS * TWO_PI)
    sol = scipy.integrate.solve_ivp(
        rhs, span, (f.q, f.w), events=contact, rtol=TOLERANCE, atol=TOLERANCE
    )
    return float(sol.t_events[0][0]) if sol.t_events[0].size else None


def careful(lift: Lift, f: Flight) -> float | None:
    """DOP853 as in the precision part; phase of the contact."""
    omega = f.rpm * pi / 30
    c, c1, _ = lift.at(f.theta)
    machine = PeerMachine(
        f.system.follower, lift, omega=omega, turns=TURNS + 1.0, chatter=0.0, seconds=SLOWEST
    )
    start = PeerState(0, f.theta, max(f.q - c, 0.0), (f.w - c1) * omega)
    try:
        hit, end = next_landing(machine, solve_ivp("dop853", TOLERANCE, 1.0 / 16.0), start)
    except (BudgetError, ArithmeticError, ValueError):
        return None
    return end.turn * TWO_PI + end.theta - f.theta if hit else None


def main() -> None:
    """Fly and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flights", type=int, default=2000)
    parser.add_argument("--ours", action="store_true", help="ours alone")
    options = parser.parse_args()
    lift, rng = Lift(reference("stability")["cam"]), np.random.default_rng(0)
    others = {} if options.ours else {"plain": plain, "careful": careful}
    found: dict[str, Counter] = {name: Counter() for name in ("ours", *others)}
    for _ in range(options.flights):
        f = random_flight("chapter", rng)
        ours = landing(f)
        outcome, expected = verdict(f, ours and ours[0])
        found["ours"][outcome] += 1
        if outcome == UNDECIDED:
            continue
        for name, peer in others.items():
            theirs = peer(lift, f)
            at, true = (inf if x is None else x for x in (theirs, expected))
            wrong = at != true and abs(at - true) > APART
            found[name][(MISSED if at > true else INVENTED) if wrong else RIGHT] += 1
    for name, outcomes in found.items():
        print(name, dict(outcomes))


if __name__ == "__main__":
    main()
