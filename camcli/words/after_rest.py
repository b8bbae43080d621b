"""Which machines an answer after a rest holds for, in sentences."""

from collections import Counter
from collections.abc import Iterable

from camcli.analysis.after_rest import HoldsFor
from camcli.errors import plural

DECIDED = {
    HoldsFor.LAST_DIGIT: "for every speed that rounds to the given one (proved)",
    HoldsFor.EXACT_DATA: (
        "for the data exactly as they are, not for every speed that rounds to them"
    ),
}


def decided_notes(holds_for: Iterable[str | None], what: str) -> list[str]:
    """Sentences on how many answers after a rest hold for which machines.

    holds_for: of each answer, None or empty where no rest had to be decided; what: one of what the
    answers are about, such as `speed`.
    """
    counts = Counter(name for name in holds_for if name)
    decided = {name: counts[name] for name in DECIDED if counts[name]}
    notes = []
    if decided:
        answers = plural(sum(decided.values()), what)
        if len(decided) == 1:
            (name,) = decided
            which = f" {DECIDED[name]}"
        else:
            which = ": " + ", ".join(f"{count} {DECIDED[name]}" for name, count in decided.items())
        notes.append(f"ball arithmetic decided what follows a rest, of {answers}{which}")
    chosen = counts[HoldsFor.ROUNDING]
    if chosen:
        notes.append(
            f"rounding chose what follows a rest, and so the attractor, of {plural(chosen, what)}: "
            "the exact motion could not be followed so far"
        )
    return notes
