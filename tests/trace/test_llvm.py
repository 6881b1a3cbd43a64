"""Machine code by LLVM: the bits of the reference for any number of samples side by side, kept and found again."""

import os
import platform
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle.jit import cache, machine
from rattle.trace import elementary, llvm, llvm_chain
from rattle.trace.graph import FUNCTIONS, Graph, select

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
ODD = [
    0.0, -0.0, 1.0, -1.0, 0.5, -0.5, -2.5, 3.0, np.inf, -np.inf, np.nan, 5e-324, -1e-310, 2.2250738585072014e-308,
    1e300, -1e300, 1.7976931348623157e308, 710.0, -745.2, 1.5707963267948966, 3.141592653589793, 4503599627370497.5,
    -4503599627370495.5, 1.0 - 2.0**-53, 1.0 + 2.0**-52,
]  # fmt: skip
X86 = platform.machine().lower() in ("x86_64", "amd64")
x86 = pytest.mark.skipif(not X86, reason="features of another processor")


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    """A cache folder for one test."""
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / llvm.FOLDER


def unaligned(count):
    """Room for numbers at a multiple of 8 bytes that is none of 16."""
    room = np.zeros(count + 2)
    first = 1 if room.ctypes.data % 16 == 0 else 0
    return room[first : first + count]


def run(code, name, inputs, count, width):
    """Outputs (count, n) for inputs (n_in, n); the first sample fills the last group up."""
    n = inputs.shape[1]
    padded = np.concatenate([inputs, np.repeat(inputs[:, :1], -n % width, axis=1)], axis=1)
    columns = padded.shape[1]
    rows, results = unaligned(padded.size), unaligned(count * columns)
    rows[:] = padded.ravel()
    code.function(name)(rows.ctypes.data, columns, results.ctypes.data, columns, columns)
    return results.reshape(count, columns)[:, :n]


def require_same_bits(graph, functions, inputs, widths=llvm.WIDTHS):
    """Every function, compiled for every width, against NumPy; nan is nan whatever its payload."""
    for width in widths:
        code = llvm.compile(llvm.functions_text(graph, functions, width), list(functions))
        for name, outputs in functions.items():
            want = graph.evaluate(outputs, inputs)
            got = run(code, name, inputs, len(outputs), width)
            differ = (got.view(np.int64) != want.view(np.int64)) & ~(np.isnan(got) & np.isnan(want))
            assert not differ.any(), (width, name, np.argwhere(differ)[:5], got[differ][:5], want[differ][:5])


# ---------------------------------------------------------------- the same bits
UNARY = ("neg", "abs", "sqrt", "floor", "exponent", "mantissa")
BINARY = ("add", "sub", "mul", "div")
COMPARED = ("less", "at_most", "equal")


@st.composite
def expressions(draw):
    """A graph of random exact operations over three inputs, its outputs numbers and flags."""
    graph = Graph()
    values = [graph.input() for _ in range(3)] + [draw(st.sampled_from(ODD)) for _ in range(2)]
    flags = [values[0] < values[1]]

    def one(of):
        return of[draw(st.integers(0, len(of) - 1))]

    for _ in range(draw(st.integers(5, 40))):
        op = draw(
            st.sampled_from((*UNARY, *BINARY * 2, *COMPARED, "both", "either", "not", "select", "number", "power"))
        )
        if op in UNARY:
            values.append(graph.apply(op, one(values)))
        elif op in BINARY:
            values.append(graph.apply(op, one(values), one(values)))
        elif op in COMPARED:
            flags.append(graph.apply(op, one(values), one(values)))
        elif op == "not":
            flags.append(graph.apply(op, one(flags)))
        elif op in ("both", "either"):
            flags.append(graph.apply(op, one(flags), one(flags)))
        elif op == "number":  # a flag that is counted with
            values.append(graph.apply("mul", one(flags), one(values)))
        elif op == "power":
            n = graph.apply("floor", one(values))
            bounded = select(n > 1000.0, 1000.0, select(n < -1000.0, -1000.0, n))
            values.append(graph.apply("power_of_two", select(bounded == bounded, bounded, 0.0)))
        else:
            values.append(select(one(flags), one(values), one(values)))
    outputs = [one(values) for _ in range(4)] + [values[-1], one(flags), flags[-1], values[0]]
    return graph, outputs


def odd_inputs(count, seed):
    random = np.random.default_rng(seed)
    return np.concatenate([random.normal(size=(count, 20)) * 4.0, random.choice(ODD, (count, 41))], axis=1)


@settings(max_examples=30)
@given(expressions(), st.integers(0, 2**32 - 1))
def test_random_expressions_have_the_bits_of_the_reference(made, seed):
    graph, outputs = made
    require_same_bits(graph, {"straight": outputs}, odd_inputs(3, seed))


def test_a_number_as_a_flag_is_true_unless_it_is_zero():
    graph = Graph()
    x = graph.input()
    outputs = [graph.apply("not", x), graph.apply("either", x, x < x), graph.apply("select", 2.0 * x, x, 7.0)]
    require_same_bits(graph, {"straight": outputs}, np.array([ODD]))


def everything():
    """All functions at two inputs, as one calculation."""
    graph = Graph()
    inputs = [graph.input(), graph.input()]
    functions = {name: [elementary.FUNCTIONS[name](*inputs[: FUNCTIONS[name]])] for name in sorted(FUNCTIONS)}
    return graph, {**functions, "power_of_two": [graph.apply("power_of_two", inputs[0])]}


def test_elementary_functions_have_the_bits_of_the_reference():
    graph, functions = everything()
    whole = {"power_of_two": functions.pop("power_of_two")}
    random = np.random.default_rng(5)
    pairs = np.array(list(map(np.ravel, np.meshgrid(ODD, ODD))))
    angles = np.arange(-60, 61) * (np.pi / 4)
    size = 10.0 ** random.uniform(-300, 300, (2, 200)) * random.choice([-1.0, 1.0], (2, 200))
    near = np.array([np.nextafter(angles, 9e9), np.nextafter(1.0, angles)])
    inputs = np.concatenate(
        [pairs, np.array([angles, -angles]), near, size, random.normal(size=(2, 200)) * 9.0], axis=1
    )
    require_same_bits(graph, functions, inputs)
    require_same_bits(graph, whole, np.array([np.arange(-1022.0, 1024.0)] * 2))


SMOOTH = ("fourbar", "squeezer", "five_bar", "windows", "toggle")


def smooth_examples():
    import rattle as rt
    from rattle.analyses.straight_line.code import straight_line

    for name in SMOOTH:
        yield name, straight_line(rt.example(name).recorded())


def test_recorded_models_have_the_bits_of_the_reference():
    for name, made in smooth_examples():
        functions = {"derivative": made.derivative, "project": made.projection, "outputs": made.outputs}
        random = np.random.default_rng(3)
        inputs = np.concatenate([[0.1], made.start, [0.0]])  # t, y, E_0
        state = inputs[:, None] + random.normal(size=(len(inputs), 9)) * 1e-3
        widths = llvm.WIDTHS if name == "fourbar" else (llvm.width(),)
        require_same_bits(made.graph, functions, state, widths)
        assert np.isfinite(made.graph.evaluate(made.derivative, state)).all(), name


def test_the_neighbours_of_a_sample_do_not_matter():
    graph, functions = everything()
    text = llvm.functions_text(graph, functions, 4)
    code = llvm.compile(text, list(functions))
    mixed = odd_inputs(2, 4)
    for name in ("sin", "pow"):
        together = run(code, name, mixed, 1, 4)
        alone = np.array([run(code, name, np.repeat(column[:, None], 4, axis=1), 1, 4)[0, 0] for column in mixed.T])
        np.testing.assert_array_equal(together[0], alone)


@x86
@pytest.mark.parametrize("cpu", ["x86-64", "x86-64-v2"])
def test_a_processor_without_fma_or_even_floor_makes_the_same_bits(monkeypatch, cpu):
    monkeypatch.setattr(llvm, "host", lambda: (cpu, ""))
    assert llvm.width() == 2
    graph, functions = everything()
    del functions["power_of_two"]  # beyond its range
    require_same_bits(graph, functions, odd_inputs(2, 7), (1, 2, 4))


@x86
def test_eight_samples_fill_one_register_where_there_are_512_bits():
    graph, functions = everything()
    text = llvm.functions_text(graph, {"sin": functions["sin"]}, 8)
    code = llvm._machine("skylake-avx512", "").emit_assembly(machine.parsed(llvm._declared(text)))
    assert "zmm" in code
    assert "ymm" not in code
    assert "vfm" not in code


# ---------------------------------------------------------------- modules
def test_functions_written_by_hand_call_recorded_ones():
    graph = Graph()
    x = graph.input()
    recorded = llvm.functions_text(graph, {"half": [abs(x) * 0.5], "sign": [x < 0.0]}, 2)
    by_hand = """define void @quarter(ptr noalias %in, i64 %a, ptr noalias %out, i64 %b, i64 %n) {
%half = alloca double, i64 %n
call void @half(ptr %in, i64 %a, ptr %half, i64 %n, i64 %n)
call void @half(ptr %half, i64 %n, ptr %out, i64 %b, i64 %n)
ret void
}
"""
    code = llvm.compile(recorded + by_hand, ["quarter", "sign"])
    assert sorted(code.addresses) == ["quarter", "sign"]
    inputs = np.array([[-8.0, 4.0, 2.0]])
    np.testing.assert_array_equal(run(code, "quarter", inputs, 1, 2), [[2.0, 1.0, 0.5]])
    np.testing.assert_array_equal(run(code, "sign", inputs, 1, 2), [[1.0, 0.0, 0.0]])


def test_a_chain_calls_functions_in_turn_on_rows_apart_in_every_tile_that_runs():
    """A row that is not 0 in one lane of the first and third tile; x, y become x + y, x y and these again, twice."""
    graph = Graph()
    x, y = graph.input(), graph.input()
    code = llvm.compile(llvm.functions_text(graph, {"f": [x + y, x * y]}, 4) + llvm_chain.CHAIN, ["f", "chain"])
    f, n = code.addresses["f"], 8
    memory = np.arange(3.0 * 6 * n).reshape(3, 6, n) / 100.0
    memory[:, 5] = 0.0
    memory[0, 5, 7] = memory[2, 5, 0] = 1.0
    want = memory.copy()
    for tile in (want[0], want[2]):
        for _ in range(2):
            tile[[2, 4]] = tile[0] + tile[1], tile[0] * tile[1]
            tile[:2, :4] = tile[2, :4] + tile[4, :4], tile[2, :4] * tile[4, :4]
    row = 8 * n  # [bytes]
    calls = np.array([f, 0, n, 2 * row, 2 * n, 8, f, 2 * row, 2 * n, 0, n, 4], np.int64)
    chain = code.function("chain", *llvm_chain.KINDS)
    chain(calls.ctypes.data, calls.size, memory.ctypes.data, memory[0].size, 3, 2, 5 * n, n, None)
    np.testing.assert_array_equal(memory, want)


def test_code_in_a_circle_of_objects_is_taken_apart_by_the_collector():
    """In a process of its own, which a wrong order would end."""
    program = """
import gc
from rattle.trace import llvm
from rattle.trace.graph import Graph

for n in range(20):
    graph = Graph()
    text = llvm.functions_text(graph, {"f": [graph.input() + float(n)]}, 1)
    circle = [llvm.compile(text, ["f"])]
    circle[0].circle = circle
    del circle
    gc.collect()
print("done")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout == "done\n", done.stderr


def test_a_function_keeps_its_code_alive():
    graph = Graph()
    x = graph.input()
    function = llvm.compile(llvm.functions_text(graph, {"double": [x + x]}, 1), ["double"]).function("double")
    rows = np.array([21.0, 0.0])
    function(rows.ctypes.data, 1, rows.ctypes.data + 8, 1, 1)
    assert rows[1] == 42.0


def test_what_is_no_code_is_refused():
    with pytest.raises(RuntimeError, match="expected top-level entity"):
        llvm.compile("nothing", ["nothing"])
    with pytest.raises(ValueError, match="machine code without other"):
        llvm.compile(simple(1.0), ["straight", "other"])
    with pytest.raises(ValueError, match="width: one of 1, 2, 4, 8 samples expected, not 3"):
        llvm.functions_text(Graph(), {}, 3)


# ---------------------------------------------------------------- kept code
def simple(summand):
    graph = Graph()
    return llvm.functions_text(graph, {"straight": [graph.input() + summand]}, 1)


def value(code):
    rows = np.array([1.0, 0.0])
    code.function("straight")(rows.ctypes.data, 1, rows.ctypes.data + 8, 1, 1)
    return rows[1]


@pytest.fixture
def compiled(monkeypatch):
    """Texts that were compiled, not found in the cache."""
    texts = []
    compile_text = llvm._object

    def counted(text, machine):
        texts.append(text)
        return compile_text(text, machine)

    monkeypatch.setattr(llvm, "_object", counted)
    return texts


def test_code_is_compiled_once_and_for_one_machine(kept, compiled, monkeypatch):
    assert value(llvm.compile(simple(2.0), ["straight"])) == 3.0
    assert value(llvm.compile(simple(2.0), ["straight"])) == 3.0
    assert len(compiled) == 1
    assert value(llvm.compile(simple(3.0), ["straight"])) == 4.0
    assert len(compiled) == 2
    cpu, features = llvm.host()
    monkeypatch.setattr(llvm, "host", lambda: (cpu, features + ",-fma"))
    llvm.compile(simple(3.0), ["straight"])
    assert len(compiled) == 3
    assert len(list(kept.glob("*.code"))) == 3


def test_damaged_code_is_made_anew(kept, compiled):
    llvm.compile(simple(2.0), ["straight"])
    (file,) = kept.iterdir()
    whole = file.read_bytes()
    places = [0, 40, len(whole) // 2, len(whole) - 1]
    flipped = [whole[:n] + bytes([whole[n] ^ 1]) + whole[n + 1 :] for n in places]
    for damaged in (b"", whole[:7], whole[: len(whole) // 2], whole[:-1], bytes(len(whole)), whole + b"\0", *flipped):
        compiled.clear()
        file.write_bytes(damaged)
        assert value(llvm.compile(simple(2.0), ["straight"])) == 3.0
        assert len(compiled) == 1
        assert file.read_bytes() == whole


def test_code_under_the_name_of_other_code_is_not_used(kept, compiled):
    llvm.compile(simple(2.0), ["straight"])
    (file,) = kept.iterdir()
    llvm.compile(simple(3.0), ["straight"])
    (other,) = set(kept.iterdir()) - {file}
    other.write_bytes(file.read_bytes())
    assert value(llvm.compile(simple(3.0), ["straight"])) == 4.0
    assert len(compiled) == 3


@pytest.mark.parametrize("what", ["gone", "a file", "no folder at all", "full"])
def test_without_a_usable_folder_code_is_compiled_again(tmp_path, monkeypatch, compiled, kept, what):
    def full(*args, **options):
        raise OSError(28, "No space left on device")

    if what == "gone":
        llvm.compile(simple(1.0), ["straight"])
        (file,) = kept.iterdir()
        file.unlink()
        kept.rmdir()
    elif what == "a file":
        (tmp_path / "cache").write_text("")
    elif what == "no folder at all":
        (tmp_path / "cache").write_text("")
        monkeypatch.setattr(cache.tempfile, "mkdtemp", full)
    else:
        monkeypatch.setattr(cache.Path, "write_bytes", full)
    compiled.clear()
    for count in (1, 2):
        assert value(llvm.compile(simple(2.0), ["straight"])) == 3.0
        assert len(compiled) == (1 if what == "a file" else count)  # a temporary folder serves this process
    assert not kept.exists() or not list(kept.iterdir())


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="rights do not hold for root")
@pytest.mark.parametrize("mode", [0o000, 0o500])
def test_a_folder_without_rights_costs_time_only(tmp_path, mode):
    (tmp_path / "cache").mkdir(mode=mode)
    assert value(llvm.compile(simple(2.0), ["straight"])) == 3.0


def test_code_that_was_not_used_for_longest_goes_first(kept, monkeypatch, compiled):
    for n in range(4):
        llvm.compile(simple(float(n)), ["straight"])
        for file in kept.iterdir():  # an hour later
            seen = file.stat()
            os.utime(file, (seen.st_mtime - 3600.0,) * 2)
    llvm.compile(simple(0.0), ["straight"])  # used again
    size = sum(file.stat().st_size for file in kept.iterdir())
    monkeypatch.setattr(llvm, "MOST", size)
    llvm.compile(simple(9.0), ["straight"])
    assert len(list(kept.iterdir())) == 2
    compiled.clear()
    llvm.compile(simple(9.0), ["straight"])
    llvm.compile(simple(0.0), ["straight"])
    assert not compiled
    llvm.compile(simple(3.0), ["straight"])
    assert len(compiled) == 1


def test_numba_is_not_imported(tmp_path):
    program = """
import ctypes, sys
from rattle.trace import elementary, llvm
from rattle.trace.graph import Graph
assert "llvmlite" not in sys.modules
graph = Graph()
lowered, outputs = elementary.lower(graph, [graph.apply("sin", graph.input())])
code = llvm.compile(llvm.functions_text(lowered, {"sine": outputs}, 1), ["sine"])
rows = (ctypes.c_double * 2)(0.5, 0.0)
code.function("sine")(ctypes.addressof(rows), 1, ctypes.addressof(rows) + 8, 1, 1)
assert abs(rows[1] - 0.479425538604203) < 1e-15
print([name for name in sys.modules if name.split(".")[0] == "numba"])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.strip() == "[]"
