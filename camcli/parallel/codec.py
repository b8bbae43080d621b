"""Plain values as bytes and back, without pickle: nothing read from a file can run code.

A value is None, bool, int, float, str, a list, tuple or range of values, or an array. It is stored
as one line of JSON, in which an array is {"dtype", "shape"}, followed by the arrays' bytes in order
(little-endian, C order). Floats keep every bit (of a NaN outside an array, that it is one); tuples
and ranges come back as lists, arrays as views that may not be written.
"""

from __future__ import annotations

import json
from math import prod
from typing import Any

DTYPES = ("<f8", "<i8", "<i4", "<i2", "|i1", "|b1", "|u1")
MOST_SIDE, MOST_SIDES = 1 << 40, 8  # of the shape of an array


def pack(value: Any) -> bytes:
    """The bytes of a value; raises TypeError for what is none of the above."""
    arrays: list[bytes] = []
    text = json.dumps(_outline(value, arrays), separators=(",", ":"))
    return b"".join([text.encode(), b"\n", *arrays])


def unpack(data: bytes) -> Any:
    """The value of these bytes; raises ValueError where they are not from `pack`."""
    end = data.index(b"\n")
    reader = _Arrays(memoryview(data)[end + 1 :])
    try:
        value = reader.fill(json.loads(data[:end]))
    except RecursionError:
        raise ValueError("found lists within lists, too many") from None
    if reader.at != len(reader.rest):
        raise ValueError(f"found {len(reader.rest) - reader.at} bytes too many")
    return value


def _outline(value: Any, arrays: list[bytes]) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple | range):
        return [_outline(item, arrays) for item in value]
    if hasattr(value, "tobytes") and hasattr(value, "dtype"):
        little = value.astype(value.dtype.newbyteorder("<"), copy=False)
        if little.dtype.str not in DTYPES:
            raise TypeError(f"no array of {little.dtype.str} is stored")
        if little.ndim == 0:
            return little.item()
        arrays.append(little.tobytes())
        return {"dtype": little.dtype.str, "shape": list(little.shape)}
    raise TypeError(f"no {type(value).__name__} is stored")


class _Arrays:
    """The bytes behind the outline, handed out in order."""

    def __init__(self, rest: memoryview):
        self.rest, self.at = rest, 0

    def fill(self, outline: Any) -> Any:
        if isinstance(outline, list):
            return [self.fill(item) for item in outline]
        return self._array(outline) if isinstance(outline, dict) else outline

    def _array(self, outline: dict) -> Any:
        import numpy as np

        name, shape = outline.get("dtype"), outline.get("shape")
        if len(outline) != 2 or not isinstance(name, str) or name not in DTYPES:
            raise ValueError(f"found an array of {name!r}")
        if not _is_shape(shape):
            raise ValueError("found an array of no shape")
        kind = np.dtype(name)
        size = prod(shape) * kind.itemsize
        if self.at + size > len(self.rest):
            raise ValueError("found fewer bytes than the arrays take")
        taken = self.rest[self.at : self.at + size]
        self.at += size
        return np.frombuffer(taken, dtype=kind).reshape(shape)


def _is_shape(shape: Any) -> bool:
    if not isinstance(shape, list) or not 1 <= len(shape) <= MOST_SIDES:
        return False
    return all(type(n) is int and 0 <= n <= MOST_SIDE for n in shape)
