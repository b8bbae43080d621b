"""Large columns of numbers as .npz: the values a CSV would have, a file per column, streamed.

Read it with numpy.load. The bytes depend on the values alone: no time stands in the archive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, BinaryIO
from zipfile import ZIP_STORED, ZipFile, ZipInfo

import numpy as np

Rows = Callable[[], Iterator[Sequence[Iterable]]]  # one set of columns after the other
WHOLE = ("period", "impacts", "chatter")  # columns of whole numbers


def write_npz(names: Sequence[str], rows: Rows, file: BinaryIO) -> None:
    """Write the columns; `rows` is called once for their length and once for each of them."""
    count = sum(len(columns[-1]) for columns in rows())
    with ZipFile(file, "w", ZIP_STORED) as archive:
        for k, name in enumerate(names):
            kind = np.dtype("<i8" if name in WHOLE else "<f8")
            with archive.open(ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array_header_1_0(member, _header(count, kind))
                for columns in rows():
                    member.write(np.asarray(columns[k], dtype=kind).tobytes())


def _header(count: int, kind: np.dtype) -> dict[str, Any]:
    return {"descr": kind.str, "fortran_order": False, "shape": (count,)}
