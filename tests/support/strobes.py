"""Tables of strobes, as the kernel takes them, from states and symbols."""

from collections.abc import Sequence
from math import inf

from camcli.kernel.orbit_loop import Strobe


def strobe_of(
    q: Sequence[float], w: Sequence[float], symbols: Sequence[float], before: int = 0
) -> Strobe:
    """So many turns of an orbit, in a table with other rows before them; inf: a chatter."""
    chatter = [int(symbol == inf) for symbol in symbols]
    impacts = [0 if symbol == inf else int(symbol) for symbol in symbols]
    others = [7] * before
    return Strobe(
        [*map(float, others), *q], [*map(float, others), *w], others + impacts, others + chatter,
        len(q), before,
    )  # fmt: skip
