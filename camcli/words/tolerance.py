"""What is said of machines within their tolerances."""

from collections.abc import Mapping

from camcli.words.in_print import parameter, written_out

NAMES = {"table_error": "the error of the table"}


def number_name(key: str) -> str:
    """What a number that may be off is called: its key."""
    return NAMES.get(key, key)


def deviations(worst: Mapping[str, float]) -> str:
    """By how many percent each number is off: follower.mass +5 %, follower.stiffness -3 %."""
    return ", ".join(f"{number_name(key)} {value:+.3g} %" for key, value in worst.items())


def worst_name(key: str, percent: float) -> str:
    """A number in two lines, with what it is off by in the worst machine."""
    quantity = parameter(key)
    name = number_name(key).removeprefix("the ") if quantity is None else quantity.name
    return f"{name}\nworst {percent:+.3g} %".replace("-", "−")


def spread_title(worst: float) -> str:
    """Above the spread of machines: the worst one."""
    return f"the worst up to {written_out(worst, 4)} rpm"
