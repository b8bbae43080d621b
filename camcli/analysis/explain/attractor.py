"""The attractor carried from one speed towards another: its runs, its box, and where they leave it.

States are (q m, dq/dtheta m/rad) at the strobe. The box holds the states of the near end and a
margin; a speed lies beyond the change where a run from the carried state has states outside.
"""

from math import inf

import numpy as np

from camcli.analysis.exponents import of_record
from camcli.analysis.integrate import Cost, Orbit, Record, Settings, Start, with_turns
from camcli.kernel.orbit_loop import IMPACT
from camcli.system import System

BOX_MARGIN = 0.05  # of the box, in widths of all states seen at both ends
LEAST = 16  # states outside the box that count as leaving: fewer may be a transient
SPEED_HALVINGS = 16  # of the interval of speeds
FIRST_SETTLE = 1000  # turns from the scene's start before the attractor is recorded


def states_of(record: Record) -> np.ndarray:
    """The states at the strobes of a record, shape (turns, 2)."""
    return np.column_stack((record.strobe_q, record.strobe_w))


def impacts_of(record: Record) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(phase rad, incoming m/rad, turn) of every impact of a record with events, as arrays."""
    kept = (record.kind == IMPACT) & (record.period >= 0)
    return record.theta[kept], record.u[kept], record.period[kept]


class CarriedAttractor:
    """The attractor that the scene's start settles on at `near`, carried towards `far` (rpm).

    stays, leaves: the last speed known at which a run stays in the box, and the first at which one
    leaves; size: widths of the states at both ends; crowding: dimension of the attractor across its
    leaves, in (0, 1], 1 where it is not known. Raises StartError for a start below the cam.
    """

    def __init__(self, system: System, settings: Settings, near: float, far: float, turns: int):
        """turns: of each run. The box is that of the states of a run at the near end."""
        self.system = system
        self.settings = settings
        self.turns = turns
        self.near = near
        self.stays = near
        self.far = far
        self.leaves = far
        self.cost = Cost()
        self.crowding = 1.0
        settle = with_turns(settings, max(settings.transient, FIRST_SETTLE), 1)
        orbit = Orbit(system, near, settle)
        orbit.run()
        self.start = orbit.as_start()
        self.ends = self.run(near), self.run(far)
        near_states, far_states = (states_of(record) for record in self.ends)
        self.size = np.ptp(np.concatenate((near_states, far_states)), axis=0) + 1e-300
        margin = BOX_MARGIN * self.size
        self.box = near_states.min(0) - margin, near_states.max(0) + margin

    def run(self, rpm: float, events: bool = False) -> Record:
        """The record of the attractor at this speed, from the state it has at the near end."""
        return self._record(rpm, self.turns, self.start, events)

    def motion(self, rpm: float, x, turns: int, events: bool = False) -> Record:
        """The record of a motion from the state x at the strobe; StartError below the cam."""
        return self._record(rpm, turns + 1, Start.at_strobe(self.system, rpm, x), events)

    def _record(self, rpm: float, turns: int, start: Start, events: bool) -> Record:
        settings = with_turns(self.settings, 0, turns)
        record = Orbit(self.system, rpm, settings, start).run(events=events)
        self.cost = self.cost + record.cost
        return record

    def measure(self, rpm: float, record: Record) -> None:
        """Set the crowding to -lambda_1/lambda_2, of the exponents of a record with events.

        J. L. Kaplan and J. A. Yorke, Lecture Notes in Mathematics 730 (1979) 204: an attractor with
        the exponents lambda_1 > 0 > lambda_2 has the dimension 1 - lambda_1/lambda_2, 1 along it.
        """
        exponents = of_record(self.system, rpm, record)
        if exponents is not None and exponents.second < 0.0 < exponents.largest < inf:
            self.crowding = min(1.0, -exponents.largest / exponents.second)

    def states(self, rpm: float, x, turns: int) -> np.ndarray:
        """The states of `motion` after 0, 1, ..., turns turns; fewer where it ends early."""
        return states_of(self.motion(rpm, x, turns))

    def outside(self, states: np.ndarray) -> int:
        """How many of the states lie outside the box of the attractor."""
        low, high = self.box
        return int(((states < low) | (states > high)).any(1).sum())

    def has_left(self, record: Record) -> bool:
        """True where a record has left the box."""
        return self.outside(states_of(record)) >= LEAST

    def way(self, rpm: float) -> float:
        """Distance of a speed from the near end, rpm."""
        return abs(rpm - self.near)

    def narrow(self) -> None:
        """Halve the bracket SPEED_HALVINGS times; the far run must have left the box."""
        for _ in range(SPEED_HALVINGS):
            middle = 0.5 * (self.stays + self.leaves)
            if self.has_left(self.run(middle)):
                self.leaves = middle
            else:
                self.stays = middle
