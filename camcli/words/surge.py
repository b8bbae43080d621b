"""What is said of spring surge."""

from camcli.analysis.surge import LIMIT, Surge

NOT_SIMULATED = "surge itself is not simulated"
UNIT = "that the limit counts in inches is inferred, not published"


def surge_words(found: Surge, holds_to: float | None) -> list[str]:
    """Sentences on the harmonics that meet the spring below a speed (rpm), none: at any speed."""
    own = f"The spring's own frequency is {found.hertz:.4g} Hz"
    top = holds_to if holds_to is not None else float("inf")
    strong = found.strong_below(top)
    below = "" if holds_to is None else f" below {holds_to:.4g} rpm"
    if not strong:
        return [
            f"{own}: no harmonic of the cam over {LIMIT:g} meets it{below}; {NOT_SIMULATED}, and "
            f"{UNIT}",
        ]
    first = strong[0]
    worst = max(strong, key=lambda one: one.factor)
    told = f"harmonic {first.number} meets it at {first.rpm:.4g} rpm with {first.factor:.2g}"
    if worst is not first:
        told += f", harmonic {worst.number} at {worst.rpm:.4g} rpm with {worst.factor:.2g}"
    return [
        f"{own}: {told}, over the usual {LIMIT:g}: there the spring surges and presses less; "
        f"{NOT_SIMULATED}, and {UNIT}",
    ]


def surge_title(found: Surge) -> str:
    """Above the chart of harmonics."""
    return f"spring of {found.hertz:.4g} Hz; {NOT_SIMULATED}"
