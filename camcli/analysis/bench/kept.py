"""Pieces of the bench one after the other, each kept where there is a journal; they are timings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from camcli.parallel import Codec, Work


def one_by_one(
    function: Callable[[Any], Any],
    pieces: Sequence,
    codec: Codec,
    work: Work | None,
    on_piece: Callable[[], None],
) -> Iterator:
    """Yield function(piece) for every piece in order; `on_piece` is called after each."""
    for found in (work or Work(threads=1)).run(function, pieces, codec):
        yield found
        on_piece()


def codec_of(kind: type, whole: Callable[[Any], bool]) -> Codec:
    """Dataclasses of plain values; what is not `whole` is not kept. Tuples come back as tuples."""

    def store(found: Any) -> list | None:
        return list(vars(found).values()) if whole(found) else None

    def load(stored: list) -> Any:
        return kind(*(tuple(x) if isinstance(x, list) else x for x in stored))

    return Codec(store, load)
