"""WebAssembly as bytes: numbers, sections, and objects that cannot become a module."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle.jit.wasm import binary
from rattle.jit.wasm.binary import BrokenModule, Reader, Section

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@given(st.integers(0, 2**63 - 1))
def test_numbers_come_back(n):
    assert Reader(binary.unsigned(n)).unsigned() == n


@given(st.integers(-(2**31), 2**31 - 1))
def test_numbers_with_a_sign_come_back(n):
    reader = Reader(binary.signed(n))
    assert reader.signed() == n
    assert not reader


def test_numbers_are_written_as_the_specification_says():
    assert binary.unsigned(624485) == bytes([0xE5, 0x8E, 0x26])
    assert binary.signed(-123456) == bytes([0xC0, 0xBB, 0x78])


def test_sections_come_back_in_their_order():
    parts = [Section(binary.TYPE, b"\0"), Section(binary.DATA_COUNT, b"\0"), binary.custom("about", b"x")]
    module = binary.written(parts)
    assert list(binary.sections(module)) == parts
    assert binary.custom_sections(module) == {"about": b"x"}


@pytest.mark.parametrize(
    ("module", "said"),
    [
        (b"MZ", "no WebAssembly module"),
        (binary.MAGIC + b"\1", "too early"),
        (binary.MAGIC + b"\1\5\0", "too early"),
        (binary.MAGIC + b"\x40\0", "unknown kind 64"),
        (binary.written([Section(binary.CODE, b"\0"), Section(binary.TYPE, b"\0")]), "out of order"),
        (binary.written([Section(binary.TYPE, b"\0"), Section(binary.TYPE, b"\0")]), "out of order"),
    ],
)
def test_what_is_no_module_is_said(module, said):
    with pytest.raises(BrokenModule, match=said):
        list(binary.sections(module))


def test_a_number_without_end_is_said():
    with pytest.raises(BrokenModule, match="too long"):
        Reader(b"\xff" * 20).unsigned()


def test_an_object_that_needs_a_function_says_which():
    entry = binary.sized(b"env") + binary.sized(b"fmod") + bytes([binary.OF_FUNCTION, 0])
    made = binary.written([Section(binary.IMPORT, binary.listed([entry]))])
    assert binary.imports(made) == [("fmod", binary.OF_FUNCTION)]
    with pytest.raises(BrokenModule, match="needed from outside: fmod"):
        binary.linked(made)
