"""The engine of pages: one module without imports, the same from the same sources, that says what it has."""

import gzip
import os
import subprocess
import sys

import pytest
from llvmlite import binding

from core_engine import in_node, new
from rattle import registry
from rattle.jit import functions
from rattle.jit.wasm import binary
from rattle.jit.wasm.engine import about, layout
from rattle.jit.workspace import ARRAYS
from rattle.pages import engine
from rattle.pages.run_image import run_image

MOST = 150_000  # bytes, compressed: it stands in every page of a mechanism with contacts
MOST_WITHOUT = 80_000  # the other one


@pytest.fixture(scope="module")
def module():
    """The engine of these sources."""
    return gzip.decompress(engine.engine_of_pages())


def test_it_is_one_small_module_that_needs_nothing(module):
    kinds = [one.kind for one in binary.sections(module)]
    assert kinds == [binary.TYPE, binary.FUNCTION, binary.TABLE, binary.MEMORY, binary.GLOBAL, binary.EXPORT,
                     binary.ELEMENT, binary.CODE, binary.DATA, binary.CUSTOM]  # fmt: skip
    assert binary.imports(module) == []
    assert set(binary.exports(module)) == {"memory", *(f"call {name}" for name in about(module)["calls"])}
    assert len(engine.engine_of_pages()) < MOST


def test_the_one_without_contacts_has_their_calls_and_is_half_as_large(module):
    small = gzip.decompress(engine.engine_of_pages(False))
    assert len(engine.engine_of_pages(False)) < MOST_WITHOUT
    told, whole = about(small), about(module)
    for name in ("calls", "layout", "arrays", "numbers", "sources"):
        assert told[name] == whole[name]
    families = {one.symbol: one.family for one in functions.natives()}
    assert {families[name] for name in told["kernels"]} == {"joint", "load", "stepper", "dense output"}


def test_it_has_every_kernel_that_may_stand_in_a_table(module):
    told = about(module)
    named = {
        one.kernel.symbol for family in registry.families() for one in registry.kinds(family).values() if one.kernel
    }
    named |= {one.symbol for one in functions.natives() if one.family and one.__module__.startswith("rattle.")}
    assert {name for name in named if name.startswith("rattle.place.rattle.")} == set(told["kernels"])
    assert len(set(told["kernels"].values())) == len(told["kernels"])
    assert all(told["kernels"].values())  # nothing stands at 0
    assert told["layout"] == layout()
    assert [name for name, _ in told["arrays"]] == list(ARRAYS)


@pytest.mark.skipif(binding.llvm_version_info[0] < 21, reason="older LLVM: bytes depend on what was made before")
@pytest.mark.long
def test_the_same_sources_give_the_same_bytes(module, tmp_path):
    """In another process, in which text is hashed otherwise, and after another function was translated."""
    code = (
        "import sys, rattle as rt; from rattle.pages import engine; from rattle.solvers.output_row import record;"
        "rt.example('slider_crank').simulate(1e-3); open(sys.argv[1], 'wb').write(engine.build())"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "7", "RATTLE_CACHE": str(tmp_path / "cache")}
    subprocess.run([sys.executable, "-c", code, tmp_path / "again.wasm"], check=True, env=environment)
    assert (tmp_path / "again.wasm").read_bytes() == module


def test_a_built_one_that_is_held_is_used_for_its_sources_alone(module, monkeypatch):
    held = engine.built()
    if held is not None and about(held)["sources"] == engine.sources():
        assert about(held)["llvmlite"] != about(module)["llvmlite"] or held == module
    monkeypatch.setattr(engine, "built", lambda contacts: module)
    monkeypatch.setattr(engine, "build", lambda contacts: pytest.fail("it was built again"))
    engine.engine_of_pages.cache_clear()
    assert gzip.decompress(engine.engine_of_pages()) == module


def test_another_module_says_nothing_of_itself():
    with pytest.raises(binary.BrokenModule, match="no engine of rattle"):
        about(binary.written([]))


def test_the_command_writes_both_and_says_their_sizes(module, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(engine, "build", lambda contacts: module if contacts else b"small")
    engine.main([str(tmp_path)])
    assert gzip.decompress((tmp_path / "engine.wasm.gz").read_bytes()) == module
    assert gzip.decompress((tmp_path / "engine_without_contacts.wasm.gz").read_bytes()) == b"small"
    assert capsys.readouterr().err.count("compressed") == 2


# ---------------------------------------------------------------- what it refuses
def test_a_workspace_of_another_version_is_refused(tmp_path):
    said = in_node(tmp_path, new("ellipse"), layout="other")
    assert said["reason"] == "version"
    assert "another version of rattle" in said["error"]


def test_a_kernel_that_it_does_not_have_is_named(tmp_path):
    said = in_node(tmp_path, new("ellipse"), tables={"joint_table": ["rattle.place.mine.wobble"]})
    assert (said["reason"], said["error"]) == ("kernel", "the engine does not have mine.wobble")


def test_a_table_without_the_kernel_that_is_called_is_an_error_in_words(tmp_path):
    said = in_node(tmp_path, new("ellipse"), tables={})
    assert said["reason"] == "failed"
    assert said["error"].startswith(
        "RuntimeError: a kernel of the family 'joint' was called, but it is not in the table"
    )


def test_a_place_without_a_kernel_is_an_error_in_words(tmp_path):
    run = new("ellipse")
    tables = {**run_image(run).description["tables"], "stepper_table": [None, None]}
    said = in_node(tmp_path, run, tables=tables)
    assert said["reason"] == "failed"
    assert "a kernel of the family 'stepper' was called" in said["error"]


def test_what_no_page_asks_for_is_left_out_and_named_if_it_is_called(tmp_path):
    """An output row that goes on with the powers at all joints."""
    wide = "const wide = { at: run.m.rows.at, shape: [run.width + 40] };"
    said = in_node(tmp_path, new("ellipse"), steps=f'{wide} run.m.call("record", 0, run.m.arrays.state, wide);')
    assert said["reason"] == "failed"
    assert said["error"] == "RuntimeError: rattle.solvers.ports.write_ports is not among these kernels"
