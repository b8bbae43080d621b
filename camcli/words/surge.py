"""What is said of spring surge."""

from math import inf

from camcli.analysis.surge import LIMIT, Surge

NOT_SIMULATED = "surge itself is not simulated"
UNIT = "that the limit counts in inches is inferred, not published"


def surge_words(found: Surge, holds_to: float | None) -> list[str]:
    """A sentence on the harmonics that meet the spring, in a list.

    holds_to: the speed (rpm) below which they count, that of the first loss; None: all count.
    """
    own = f"The spring's own frequency is {found.hertz:.4g} Hz"
    strong = found.strong_below(inf if holds_to is None else holds_to)
    below = "" if holds_to is None else f" below {holds_to:.4g} rpm"
    if not strong:
        return [
            f"{own}: no harmonic of the cam over {LIMIT:g} meets it{below}; {NOT_SIMULATED}, and "
            f"{UNIT}",
        ]
    first = strong[0]
    strongest = max(strong, key=lambda harmonic: harmonic.factor)
    meetings = f"harmonic {first.number} meets it at {first.rpm:.4g} rpm with {first.factor:.2g}"
    if strongest is not first:
        at = f"{strongest.rpm:.4g} rpm with {strongest.factor:.2g}"
        meetings += f", harmonic {strongest.number} at {at}"
    return [
        f"{own}: {meetings}, over the usual {LIMIT:g}: there the spring surges and presses less; "
        f"{NOT_SIMULATED}, and {UNIT}",
    ]


def surge_title(found: Surge) -> str:
    """Above the chart of harmonics."""
    return f"spring of {found.hertz:.4g} Hz"
