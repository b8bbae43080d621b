"""Numbers, labels and values as they stand in a picture or on paper."""

import re
from math import ceil, floor, log10

from camcli.analysis.multipliers import multipliers
from camcli.quantities import PARAMETERS, RPM, VARIABLE, Quantity, drawn
from camcli.words.speeds import at_speed, number_range


def number_text(value: float) -> str:
    """A number as it reads best: 190, 198.56, 739.378."""
    return f"{value:.10g}".replace("-", "−")


def with_minus_signs(text: str) -> str:
    """A text of the screen as it stands on a page: with a minus sign before a negative number."""
    return re.sub(r"(?<![\w.)])-(?=[\d.])|(?<=\de)-(?=\d)", "−", text)


def range_of(low: float, high: float) -> str:
    """Two numbers as a range for print, `660 to 760`; a single one where both read alike."""
    return number_range(low, high).replace("-", "−")


def written_out(value: float, digits: int) -> str:
    """A number of so many significant digits without a power of ten: 12340, 0.000021."""
    text = f"{value:.{digits}g}"
    if "e" not in text:
        return text
    rounded = float(text)
    places = 0 if abs(rounded) >= 1.0 else digits - 1 - floor(log10(abs(rounded)))
    return f"{rounded:.{places}f}".rstrip("0") if places else f"{rounded:.0f}"


def with_error(value: float, error: float) -> str:
    """A number and its error, with no digit beyond those that the error leaves: 0.55 +- 0.03.

    error: 0 of a number that has none; it then stands alone.
    """
    if not error > 0.0:
        return f"{value:.6g}"
    decimals = max(0, ceil(-log10(error)))
    return f"{value:.{decimals}f} +- {written_out(error, 1)}"


def label_text(label: str, longest: int = 32) -> str:
    """A label for print: P(1;∞), long ones cut."""
    text = label.replace("inf", "∞")
    return text if len(text) <= longest else text[: longest - 2].rstrip(":;") + "…)"


def valued(key: str, value: str, rpm: float | None = None, kind: str = "") -> str:
    """A value of what is varied: `700 rpm`, `coefficient of restitution 0.8 at 700 rpm`.

    value: its text; rpm: of the run, named behind the value of another number than the speed.
    kind: of the cam; the frequency of an oscillator is its speed.
    """
    quantity = parameter(key)
    if quantity is RPM:
        return f"{value} rpm"
    beside = "" if rpm is None else at_speed([key], rpm, kind)
    if quantity is None:
        return f"{key} {value}{beside}"
    return f"{quantity.name} {value} {drawn(quantity.unit)}".rstrip() + beside


def one_of(key: str) -> str:
    """What one value of what is varied is called."""
    return "speed" if parameter(key) is RPM else "value"


def parameter(key: str) -> Quantity | None:
    """What a key of the scene is; a constant of the follower is known by its name alone too.

    None of a number that no run can vary.
    """
    return VARIABLE.get(key) or PARAMETERS.get(key)


def name_and_unit(key: str) -> tuple[str, str]:
    """What is varied, by name and unit."""
    quantity = parameter(key)
    return (key, "") if quantity is None else (quantity.name, drawn(quantity.unit))


def newtons(value: float, digits: int) -> str:
    """A force for print, with a minus sign, no negative zero and no power of ten."""
    return f"{written_out(round(value, 6) + 0.0, digits)} N".replace("-", "−")


def pair(trace: float, det: float) -> str:
    """The multipliers of a map with this trace and determinant, as text."""
    upper, lower = multipliers(trace, det)
    if upper.imag:
        text = f"{upper.real:.4g} ± {upper.imag:.4g}i"
    else:
        text = f"{upper.real:.4g}, {lower.real:.4g}" if upper != lower else f"{upper.real:.4g}"
    return text.replace("-", "−")
