"""What is said of machines within their tolerances."""

from collections.abc import Mapping

from camcli.words.in_print import parameter, written_out

MANY = 1000  # machines: of fewer a share of the variance is not known to a percent
NAMES = {"table_error": "the error of the table"}


def number_name(key: str) -> str:
    """What a number that may be off is called: its key."""
    return NAMES.get(key, key)


def deviations(worst: Mapping[str, float]) -> str:
    """By how many percent each number is off: follower.mass +5 %, follower.stiffness -3 %."""
    return ", ".join(f"{number_name(key)} {value:+.3g} %" for key, value in worst.items())


def share_words(share: float, machines: int) -> str:
    """How much of the variance a number explains, with the digits that so many machines deserve.

    The standard error of a share s of n machines is at most that of a squared correlation,
    2 sqrt(s) (1 - s)/sqrt(n): at most 0.77/sqrt(n), 0.08 of a hundred, 0.024 of a thousand.
    """
    if machines < MANY:
        return f"about {10.0 * round(10.0 * share):.0f} % of the variance"
    return f"{100.0 * share:.0f} % of the variance"


def worst_name(key: str, percent: float) -> str:
    """A number in two lines, with what it is off by in the worst machine."""
    quantity = parameter(key)
    name = number_name(key).removeprefix("the ") if quantity is None else quantity.name
    return f"{name}\nworst {percent:+.3g} %".replace("-", "−")


def spread_title(worst: float) -> str:
    """Above the spread of machines: the worst one."""
    return f"the worst up to {written_out(worst, 4)} rpm"
