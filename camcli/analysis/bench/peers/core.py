"""Our own kernel: the same run, every event logged."""

from __future__ import annotations

from camcli.analysis.bench.peers.world import Trace
from camcli.analysis.integrate import IMPACT, Orbit, Settings, Start
from camcli.kernel.orbit_loop import CHATTER
from camcli.system import System


def run(system: System, rpm: float, start: tuple, turns: int, tolerance: float) -> Trace:
    """One run from theta = 0 at a chatter tolerance in turns."""
    orbit = Orbit(system, rpm, Settings(0, turns, tolerance, 10**6, Start(*start)))
    tape = orbit.run(strobes=False)
    q, w = orbit.position()
    rows = list(zip(tape.kind, tape.period, tape.theta, tape.u, strict=True))
    return Trace(
        hits=[(int(p), float(x), float(u) * orbit.omega) for k, p, x, u in rows if k == IMPACT],
        rests=[(int(p), float(x)) for k, p, x, _ in rows if k == CHATTER],
        final=(q, w * orbit.omega),
        evaluations=tape.cost.evaluations,
    )
