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


def decided_notes(found: Iterable[str | None], what: str) -> list[str]:
    """Sentences on the machines that answers after a rest hold for; what: one of them."""
    counts = Counter(filter(None, found))
    parts = [(counts[name], text) for name, text in DECIDED.items() if counts[name]]
    notes = []
    if parts:
        decided = plural(sum(count for count, _ in parts), what)
        each = ": " + ", ".join(f"{count} {text}" for count, text in parts)
        each = f" {parts[0][1]}" if len(parts) == 1 else each
        notes.append(f"ball arithmetic decided what follows a rest, of {decided}{each}")
    if chosen := counts[HoldsFor.ROUNDING]:
        notes.append(
            f"rounding chose what follows a rest, and so the attractor, of {plural(chosen, what)}: "
            "the exact motion could not be followed so far"
        )
    return notes
