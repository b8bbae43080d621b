"""What was proved of chaos, and what that does not say."""

from collections.abc import Iterator
from math import floor

from camcli.analysis.chaos.section import Chaos
from camcli.words.proofs import FAILED, closed_flank


def chaos_sentences(chaos: Chaos) -> Iterator[str]:
    """The theorem in words, and what it leaves open; or the step at which it failed."""
    if chaos.step is not None:
        yield f"not proved: chaos at {chaos.rpm!r} rpm: {FAILED[chaos.step]}"
        return
    if chaos.flank_excess:
        yield closed_flank(chaos.flank_excess)
    yield (
        f"proved: chaos at {chaos.rpm!r} rpm and every value that rounds to it: {theorem(chaos)}"
    )
    yield (
        "so there are infinitely many periodic orbits, and the topological entropy is at least "
        f"log({chaos.growth!r}), above {_below(chaos.per_impact)} per impact, "
        f"{_below(chaos.per_turn)} per turn and {_below(chaos.per_second)} per second"
    )
    yield (
        "this does not say that the attractor is chaotic, nor that a start chosen at random ever "
        "follows one of these motions"
    )


def chaos_title(chaos: Chaos) -> str:
    """The title of its picture."""
    return f"Chaos {'proved' if chaos.proved else 'not proved'} at {chaos.rpm:.10g} rpm"


def chaos_caption(chaos: Chaos) -> str:
    """The caption below a picture of chaos."""
    if not chaos.proved:
        return ""
    return (
        f"{len(chaos.boxes)} boxes of impacts, of which {len(chaos.coverings)} pairs cover one "
        f"another: the topological entropy is at least {_below(chaos.per_turn)} per turn"
    )


def theorem(chaos: Chaos) -> str:
    """The sentence that the boxes prove."""
    count = len(chaos.boxes)
    return (
        f"there are {count} boxes of impacts about {chaos.label} and along a chain of impacts that "
        f"leaves it and comes back, and {len(chaos.coverings)} pairs of them in which one covers "
        "the other (chaos.csv); for every sequence of boxes in which each covers the next there is "
        "a motion whose impacts lie in them in turn, a periodic one where the sequence is periodic"
    )


def _below(value: float) -> str:
    """A number rounded down, to four decimals."""
    return f"{floor(value * 1e4) / 1e4:.4f}"
