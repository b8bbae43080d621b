"""Values as bytes and back; bytes from elsewhere raise ValueError and nothing else."""

import json
import struct
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from camcli.parallel.codec import DTYPES, pack, unpack

HARD = [0.0, -0.0, 5e-324, -5e-324, 2.2e-308, 1.8e308, float("inf"), -float("inf"), 0.1, 1 / 3]
SHAPES = arrays_of.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=4)
ARRAYS = st.sampled_from(DTYPES).flatmap(
    lambda kind: arrays_of.arrays(np.dtype(kind), SHAPES, fill=st.nothing())
)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
VALUES = st.recursive(SCALARS | ARRAYS, lambda inner: st.lists(inner, max_size=4), max_leaves=12)


def same(a, b) -> bool:
    """Equal in type and to the last bit."""
    if isinstance(a, np.ndarray):
        return (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
    if isinstance(a, float):
        return isinstance(b, float) and (a != a != b or struct.pack("d", a) == struct.pack("d", b))
    if isinstance(a, list | tuple | range):
        return len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and a == b


@given(VALUES)
def test_every_value_comes_back(value):
    assert same(value, unpack(pack(value)))


@pytest.mark.parametrize("value", HARD)
def test_hard_floats_keep_every_bit_alone_and_in_arrays(value):
    assert same(value, unpack(pack(value)))
    assert same(np.array([value]), unpack(pack(np.array([value]))))


def test_every_nan_of_an_array_keeps_its_bits():
    bits = np.array([0x7FF8000000000001, 0xFFF8000000000000, 0x7FF0000000000001], dtype="<u8")
    assert unpack(pack(bits.view("<f8"))).tobytes() == bits.tobytes()


def test_what_is_a_list_or_a_number_afterwards():
    assert unpack(pack((1, range(3), [True]))) == [1, [0, 1, 2], [True]]
    number = unpack(pack([np.float64(0.1), np.int32(7), np.bool_(True)]))
    assert [type(n) for n in number] == [float, int, bool]
    assert same(np.array([1.0, 2.0]), unpack(pack(np.array([1.0, 2.0], dtype=">f8"))))
    assert same(np.arange(6.0).reshape(2, 3).T, unpack(pack(np.arange(6.0).reshape(2, 3).T)))


@pytest.mark.parametrize("value", [{}, {1}, object(), b"x", np.array(["x"]), np.array([1j]), 1j])
def test_what_is_not_stored(value):
    with pytest.raises(TypeError):
        pack([value])


@given(st.binary(max_size=64))
def test_random_bytes_are_refused_or_are_a_value(data):
    refused_or_read(data)


LIES = st.one_of(
    st.integers(), st.floats(), st.text(max_size=3), st.none(), st.booleans(),
    st.lists(st.one_of(st.integers(), st.integers(0, 3), st.booleans(), st.none()), max_size=12),
)  # fmt: skip
NAMES = st.sampled_from([*DTYPES, "O", "<f4", "V8", "|S9", "object", [], None, 3])


@settings(max_examples=500)
@given(st.dictionaries(st.sampled_from(["dtype", "shape", "x"]), LIES | NAMES), st.binary())
def test_arrays_that_lie_are_refused(outline, rest):
    refused_or_read(json.dumps([outline]).encode() + b"\n" + rest)


@pytest.mark.parametrize(
    "shape",
    [
        [-1], [-1, -8], [1 << 62], [1 << 32, 1 << 32], [1 << 31, 1 << 31, 4], [10**30], [0, 10**30],
        [2.0], [True], ["2"], "2", None, 2, [[2]], [], {}, [0, 1 << 63], [1] * 70, [0, -1],
    ],
)  # fmt: skip
@pytest.mark.parametrize("rest", [b"", b"12345678"])
def test_shapes_that_lie_allocate_nothing(shape, rest):
    data = json.dumps({"dtype": "<f8", "shape": shape}).encode() + b"\n" + rest
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"."):
        unpack(data)
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


@pytest.mark.parametrize(
    "data",
    [b"", b"\n", b"1", b"\xff\n", b"{}\n", b"1\n2", b"[" * 100_000 + b"\n", b"9" * 5000 + b"\n",
     b"[" * 600 + b"]" * 600 + b"\nx", b'{"dtype":"|u1","shape":[2]}\n1'],
)  # fmt: skip
def test_broken_bytes_are_refused(data):
    with pytest.raises(ValueError, match=r"."):
        unpack(data)


@given(VALUES, st.data())
def test_a_flipped_bit_or_a_cut_is_refused_or_another_value(value, data):
    whole = bytearray(pack(value))
    at = data.draw(st.integers(0, len(whole) * 8 - 1))
    whole[at // 8] ^= 1 << at % 8
    refused_or_read(bytes(whole))
    refused_or_read(pack(value)[: at // 8])


def refused_or_read(data: bytes) -> None:
    with suppress(ValueError):
        unpack(data)
