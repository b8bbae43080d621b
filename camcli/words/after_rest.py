"""Which machines an answer after a rest holds for, in sentences."""

from collections import Counter
from collections.abc import Iterable

from camcli.analysis.after_rest import HoldsFor

DECIDED = {
    HoldsFor.LAST_DIGIT: "for every speed that rounds to the given one (proved)",
    HoldsFor.EXACT_DATA: "for the data exactly as they are, not for every speed that rounds so",
}


def decided_notes(found: Iterable[str | None], what: str) -> list[str]:
    """Sentences on the machines that answers after a rest hold for; `what` was decided."""
    counts = Counter(filter(None, found))
    parts = [f"{counts[name]} {text}" for name, text in DECIDED.items() if counts[name]]
    notes = []
    if parts:
        notes.append(f"{what} decided in ball arithmetic after a rest: {', '.join(parts)}")
    if counts[HoldsFor.ROUNDING]:
        notes.append(
            f"{what} on an attractor that rounding chose: {counts[HoldsFor.ROUNDING]}; where their "
            "own start ends could not be followed so far"
        )
    return notes
