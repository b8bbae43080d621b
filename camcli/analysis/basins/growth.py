"""How differences grow on an attractor: multipliers where solved, else a measured exponent."""

from __future__ import annotations

from math import inf, sqrt

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.exponents import of_tape
from camcli.analysis.integrate import Orbit, Settings, Start, with_turns
from camcli.errors import Status
from camcli.kernel.growth import natural_log
from camcli.system import System, omega_of

RECORD = 4000  # turns of an aperiodic attractor


def largest_exponent(
    system: System, rpm: float, settings: Settings, attractor: Attractor
) -> float | None:
    """Largest Lyapunov exponent per turn: ln |multiplier|/m, or from a record; -inf after a rest.

    None where a record shows too little.
    """
    if attractor.multipliers is not None:
        z = complex(attractor.multipliers[0])
        size = sqrt(z.real * z.real + z.imag * z.imag)
        return natural_log(size) / attractor.turns if size > 0.0 else -inf
    if attractor.periodic:
        return -inf
    q, w = attractor.states[0]
    start = Start(q, w * omega_of(rpm), system.strobe_deg)
    tape = Orbit(system, rpm, with_turns(settings, 0, RECORD), start).run()
    found = of_tape(system, rpm, tape) if tape.status == Status.OK else None
    return None if found is None else found.largest
