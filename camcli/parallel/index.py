"""Where the records of a journal are: eight bytes for each piece, however many there are."""

from __future__ import annotations

from array import array
from collections.abc import Iterator

PARTS = 1 << 16  # files at most
SPARSE = 1 << 20  # a number this far beyond the last one is kept by its name


class Index:
    """(file, offset) by name; a name like `place/7` takes no more than its place in an array."""

    def __init__(self) -> None:
        self._arrays: dict[str, array] = {}  # 1 + file + PARTS offset, 0: none
        self._others: dict[str, int] = {}
        self._count = 0

    def put(self, name: str, file: int, offset: int) -> None:
        """Keep where a record begins; a later one of the same name counts."""
        value = 1 + file + PARTS * offset
        self._count += name not in self
        place, k = _split(name)
        numbers = self._arrays.setdefault(place, array("q")) if k >= 0 else None
        if numbers is None or k - len(numbers) > SPARSE:
            self._others[name] = value
            return
        if k >= len(numbers):
            numbers.extend([0] * (k + 1 - len(numbers)))
        numbers[k] = value

    def get(self, name: str) -> tuple[int, int]:
        """(file, offset); raises KeyError."""
        value = self._value(name)
        if value == 0:
            raise KeyError(name)
        return (value - 1) % PARTS, (value - 1) // PARTS

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._value(name) != 0

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[str]:
        for place, numbers in self._arrays.items():
            yield from (f"{place}/{k}" for k, value in enumerate(numbers) if value)
        yield from self._others

    def _value(self, name: str) -> int:
        place, k = _split(name)
        numbers = self._arrays.get(place, ())
        found = numbers[k] if 0 <= k < len(numbers) else 0
        return found or self._others.get(name, 0)


def _split(name: str) -> tuple[str, int]:
    """(place, number) of `place/number`, (name, -1) of any other."""
    place, slash, number = name.rpartition("/")
    plain = slash and number.isascii() and number.isdigit() and len(number) < 16
    if plain and (number == "0" or number[0] != "0"):
        return place, int(number)
    return name, -1
