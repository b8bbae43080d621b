"""What `cam figures` says of numbers that are not the reference's."""

from collections.abc import Sequence
from typing import Any

from camcli.errors import plural

NO_REFERENCE = "there is no reference yet"
PORTABILITY = "portability broke"


def drift_verdict(numbers: int, figures: int, broken: int, missing: int = 0) -> str:
    """What the drifts mean together.

    numbers: that drifted; figures: in which they did; broken: numbers that another machine's bits
    would explain; missing: figures without a reference.
    """
    if missing:
        have = "figure has" if missing == 1 else "figures have"
        text = f"{missing} {have} no reference to compare with: --update-reference makes one"
        return f"{drift_verdict(numbers, figures, broken)}; {text}" if numbers else text
    if not numbers:
        return "every number is the reference's"
    words = f"{plural(numbers, 'number')} drifted in {plural(figures, 'figure')}"
    if broken == numbers:
        words += f": {PORTABILITY}: only chaotic motions and last bits differ"
    elif broken:
        words += f", {broken} of them where bits should agree on every machine ({PORTABILITY})"
    return words


def drift_line(drift: Any, chaotic: bool) -> str:
    """A number, what the reference has, and what was found.

    drift: an `output.digest.Drift`; chaotic: whether it is of a motion that does not repeat.
    """
    name = f"{drift.figure}: {drift.name}"
    if chaotic:
        name += " (chaotic)"
    reference = "nothing" if drift.reference is None else str(drift.reference)
    found = "nothing" if drift.found is None else str(drift.found)
    text = f"{name}: reference {reference}, found {found}"
    if drift.by is not None:
        text += f", off by {drift.by:.6g}"
        if drift.reference:
            text += f" ({abs(drift.by / drift.reference):.2g} of it)"
    if drift.portability:
        text += f": {PORTABILITY}"
    return text


def more_drifts(figure: str, count: int) -> str:
    """The drifts of a figure that are not listed."""
    return f"{figure}: and {count} more (--json has all of them)"


def no_room(panels: Sequence[str]) -> str:
    """Which panels are left out of a page that is too low for them, and how to see them."""
    return f"no room for {', '.join(panels)} (--panels draws them alone, --height a taller page)"


def computed_line(page: str, done: int, asked: int, seconds: float) -> str:
    """How much was computed, and where to look."""
    return f"{page}: {done} of {plural(asked, 'figure')} computed in {seconds:.3g} s"


def caption_lacks(name: object) -> str:
    """What stands for a caption with a number that the run does not have."""
    return f"(The caption names {name}, which this run does not have.)"


def certificate_refused(lines: list[str]) -> str:
    """What is said of a figure whose certificate its checker does not confirm; lines: its words."""
    refused = next((line for line in lines if not line.startswith("confirmed: ")), "")
    return f"its certificate is not confirmed: {refused}"
