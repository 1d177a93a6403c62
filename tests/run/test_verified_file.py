"""One form for numbers, texts and arrays as bytes: what comes back is what was given, and nothing else is written."""

import hashlib
from dataclasses import dataclass

import msgpack
import numpy as np
import pytest
from cosimo.orchestrator.verified_file import DamagedFile, packed, unpacked, verified_bytes, verified_content
from hypothesis import given
from hypothesis import strategies as st

plain = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary()
data = st.recursive(
    plain,
    lambda some: st.lists(some) | st.tuples(some, some) | st.dictionaries(st.text() | st.tuples(st.text(), st.integers()), some),
    max_leaves=20,
)


@given(data)
def test_what_is_packed_comes_back_with_its_types(value):
    again = unpacked(packed(value))
    assert again == value
    assert repr(again) == repr(value)


@dataclass
class Pair:
    a: float
    b: tuple[int, ...]


def test_arrays_keep_every_bit_and_can_be_written_to():
    nan = np.frombuffer(b"\x01\x00\x00\x00\x00\x00\xf8\x7f")
    for array in (nan, np.zeros((0, 3)), np.arange(6, dtype="<i4").reshape(2, 3).T, np.array(["a", "bcd"])):
        again = unpacked(packed([array]))[0]
        assert (again.dtype, again.shape, again.tobytes()) == (array.dtype, array.shape, array.tobytes())
        again[...] = again
    assert unpacked(packed([np.float64(0.1), np.int32(3), np.bool_(True), Pair(1.0, (2,))])) == [
        0.1,
        3,
        True,
        {"a": 1.0, "b": (2,)},
    ]


@pytest.mark.parametrize("value", [object(), {1, 2}, np.array([object()]), Pair, lambda: None])
def test_nothing_else_is_packed(value):
    with pytest.raises(TypeError, match="neither number, text, array, list nor mapping"):
        packed([value])


def test_other_bytes_and_damage_are_told_apart():
    whole = verified_bytes({"a": np.arange(3.0)})
    with pytest.raises(ValueError, match="no content with a digest"):
        verified_content(b"PK" + whole)
    with pytest.raises(DamagedFile):
        verified_content(whole[:-1])
    for content in (b"\xc1", msgpack.packb(msgpack.ExtType(0, packed(["|O", [1], b"12345678"]))), b"\x91" * 5000):
        forged = verified_bytes(0)[:14] + hashlib.sha256(content).digest() + content
        with pytest.raises(ValueError, match="no data"):
            verified_content(forged)
