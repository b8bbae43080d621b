"""One period of a periodic orbit in time, as a picture of it shows."""

from collections.abc import Sequence

from camcli.analysis.integrate import Settings, Start
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.simulate import Simulation, simulate
from camcli.system import System

MOST_SHOWN = 16  # orbits that a picture shows in time
CHATTER_TOLERANCE, IMPACT_BUDGET, SAMPLES = 1e-9, 10**6, 360  # of each of them


def periods_of(orbits: Sequence[PeriodicOrbit], system: System) -> list[Simulation]:
    """One period of each of the first MOST_SHOWN orbits, from its first state at the strobe."""
    return [_one_period(orbit, system) for orbit in orbits[:MOST_SHOWN]]


def _one_period(orbit: PeriodicOrbit, system: System) -> Simulation:
    start = Start.at_strobe(system, orbit.rpm, orbit.states[0])
    settings = Settings(0, orbit.turns, CHATTER_TOLERANCE, IMPACT_BUDGET, start)
    return simulate(system, orbit.rpm, settings, SAMPLES, follow=False)
