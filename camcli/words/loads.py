"""What a speed loads, as the columns of a table have it."""

from math import degrees

from camcli.analysis.loads import Loads
from camcli.quantities import LOADS, SEAT

ANGLES = {  # columns in degrees, of what is in rad
    "contact_lost_deg": "contact_lost",
    "contact_regained_deg": "contact_regained",
    "landing_deg": "landing",
    "seat_open_deg": "seat_open",
    "seat_open_lash_deg": "seat_open_lash",
    "seat_open_drawn_deg": "seat_open_drawn",
}


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
