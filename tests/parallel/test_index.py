"""Records by name, eight bytes each."""

import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from camcli.parallel.index import PARTS, SPARSE, Index

NAMES = st.one_of(
    st.builds("{}/{}".format, st.sampled_from(["0", "0/1", ""]), st.integers(0, 50)),
    st.sampled_from(["end", "0/07", "0/-1", "0/²", "0/", f"0/{10**20}", f"0/{2 * SPARSE}"]),
    st.text(max_size=5),
)
PLACES = st.tuples(st.integers(0, PARTS - 1), st.integers(0, 1 << 46))


@given(st.dictionaries(NAMES, PLACES), st.dictionaries(NAMES, PLACES))
def test_it_is_a_dictionary(first, later):
    index, plain = Index(), {}
    for found in (first, later):
        for name, (file, offset) in found.items():
            index.put(name, file, offset)
        plain.update(found)
    assert {name: index.get(name) for name in index} == plain
    assert len(index) == len(plain)
    for name in ("0/3", "0/51", "other"):
        assert (name in index) == (name in plain)
        if name not in plain:
            with pytest.raises(KeyError):
                index.get(name)


def test_a_million_pieces_take_little():
    index = Index()
    for k in range(1_000_000):
        index.put(f"0/{k}", 0, 3000 * k)
    (numbers,) = index._arrays.values()
    assert sys.getsizeof(numbers) < 10_000_000
    assert index.get("0/999999") == (0, 3000 * 999_999)
