"""What a speed loads, as the columns of a table have it."""

from enum import StrEnum
from math import degrees, tau

from camcli.analysis.loads import Loads
from camcli.quantities import LOADS, SEAT
from camcli.system import System

ANGLES = {  # columns in degrees, of what is in rad
    "contact_lost_deg": "contact_lost",
    "contact_regained_deg": "contact_regained",
    "landing_deg": "landing",
    "seat_open_deg": "seat_open",
    "seat_open_lash_deg": "seat_open_lash",
    "seat_open_drawn_deg": "seat_open_drawn",
}

BESIDE = 1e-9  # rad: a phase that was in deg may be off its corner by some 1e-15


class Struck(StrEnum):
    """What a follower strikes that is shut or shuts: its seat, or the lobe that opens it."""

    SEAT = "seat"
    BLOW = "blow"


def struck(system: System, theta: float) -> Struck | None:
    """Whether an impact at a phase (rad) is one on the seat, or the opening blow; None: neither.

    The lobe opens where the seat's stretch of the turn ends, and sets the follower down where that
    stretch begins.
    """
    if not system.has_seat:
        return None
    if system.is_seat((theta + BESIDE) % tau):
        return Struck.SEAT
    return Struck.BLOW if system.is_seat((theta - BESIDE) % tau) else None


def load(loads: Loads, column: str) -> float | None:
    """The number of a column; None where it does not apply."""
    if column not in ANGLES:
        return getattr(loads, column)
    theta = getattr(loads, ANGLES[column])
    return None if theta is None else degrees(theta)


def load_row(loads: Loads) -> list[float | None]:
    """The numbers of all columns, in the order of LOADS."""
    return [load(loads, column) for column in LOADS]


def seat_row(loads: Loads) -> list[float | None]:
    """The numbers of the columns of the seat, in the order of SEAT."""
    return [load(loads, column) for column in SEAT]
