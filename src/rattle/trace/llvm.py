"""Straight-line code as machine code, for W samples side by side, by LLVM.

A function `void name(double *in, int64 a, double *out, int64 b, int64 n)` reads rows of n samples, in[k a + sample],
and writes such rows, out[k b + sample], W samples at a time.  Every operation is one instruction without fast-math
flags, and LLVM contracts nothing that is not marked for it, so each sample has the bits of `Graph.evaluate`, whatever W
and the processor are.  The graph is shared and folded already, so none of LLVM's passes over its intermediate form run:
they took as long as all the rest and changed no speed.

Code is kept in the cache folder, see `rattle.jit.cache`.  LLVM is imported when needed.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib
import os
import pickle
import re
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from rattle.errors import InputError
from rattle.jit.cache import KeptFile, code_folder
from rattle.language.recorded import Operand
from rattle.trace.graph import FLAGS, ROUND, Graph

WIDTHS = (1, 2, 4, 8)
LEVEL = 1  # of LLVM's code generator: 2 took 15 to 30 % longer and made no faster code
MOST = 100_000_000  # bytes of kept code; beyond, the files that were not used for longest go, down to half of it
FOLDER = "straight_line"  # name of the folder of kept code

# {r} result, {0} {1} {2} operands; {V} numbers, {I} their bits, {B} flags, {v} what names of intrinsics end in;
# {name:...} numbers that are the same in all lanes, see `_Width`
FORMS = {
    "add": "{r} = fadd {V} {0}, {1}",
    "sub": "{r} = fsub {V} {0}, {1}",
    "mul": "{r} = fmul {V} {0}, {1}",
    "div": "{r} = fdiv {V} {0}, {1}",
    "neg": "{r} = fneg {V} {0}",
    "abs": "{r} = call {V} @llvm.fabs.{v}({V} {0})",
    "sqrt": "{r} = call {V} @llvm.sqrt.{v}({V} {0})",
    "floor": "{r} = call {V} @llvm.floor.{v}({V} {0})",
    "less": "{r} = fcmp olt {V} {0}, {1}",
    "at_most": "{r} = fcmp ole {V} {0}, {1}",
    "equal": "{r} = fcmp oeq {V} {0}, {1}",
    "both": "{r} = and {B} {0}, {1}",
    "either": "{r} = or {B} {0}, {1}",
    "not": "{r} = xor {B} {0}, {true}",
    "select": "{r} = select {B} {0}, {V} {1}, {V} {2}",
    "power_of_two": """{r}.a = fadd {V} {0}, {shift}
{r}.b = bitcast {V} {r}.a to {I}
{r}.c = shl {I} {r}.b, {i52}
{r} = bitcast {I} {r}.c to {V}""",
    # a whole number n from 0 to 2047 becomes a double as the lowest bits of 2^52 + n
    "exponent": """{r}.a = bitcast {V} {0} to {I}
{r}.b = lshr {I} {r}.a, {i52}
{r}.c = and {I} {r}.b, {i2047}
{r}.d = or {I} {r}.c, {bits_of_2_52}
{r}.e = bitcast {I} {r}.d to {V}
{r} = fsub {V} {r}.e, {bias}""",
    "mantissa": """{r}.a = bitcast {V} {0} to {I}
{r}.b = and {I} {r}.a, {fraction}
{r}.c = or {I} {r}.b, {bits_of_1}
{r} = bitcast {I} {r}.c to {V}""",
}
LOGICAL = {"both": 2, "either": 2, "not": 1, "select": 1}  # how many operands, from the first, are flags
PARAMETERS = "ptr noalias readonly %in, i64 %a, ptr noalias %out, i64 %b, i64 %n"
AS_NUMBER = "{r} = select {B} {0}, {V} {one}, {V} {zero}"
AS_FLAG = "{r} = fcmp une {V} {0}, {zero}"
# row {0} or {1}, at the present samples
READ = """{r}.k = mul i64 %a, {0}
{r}.i = add i64 {r}.k, %i
{r}.p = getelementptr double, ptr %in, i64 {r}.i
{r} = load {V}, ptr {r}.p, align 8"""
WRITE = """{r}.k = mul i64 %b, {1}
{r}.i = add i64 {r}.k, %i
{r}.p = getelementptr double, ptr %out, i64 {r}.i
store {V} {0}, ptr {r}.p, align 8"""
DECLARED = re.compile(r"call ((?:<\d+ x )?double>?) (@llvm\.(?:fabs|sqrt|floor)\.\w+)\(")


def bits(x: float) -> int:
    """The 64 bits of a number."""
    return int(struct.unpack("<Q", struct.pack("<d", x))[0])


class _Width:
    """How types and constants are written for W samples."""

    def __init__(self, width: int) -> None:
        if width not in WIDTHS:
            raise InputError(f"width: one of {', '.join(map(str, WIDTHS))} samples expected, not {width}")
        self.width = width
        self._numbers: dict[int, str] = {}  # by their bits
        integer, number = functools.partial(self._lanes, "i64"), self.number
        words = {
            "V": self._type("double"), "I": self._type("i64"), "B": self._type("i1"),
            "v": "f64" if width == 1 else f"v{width}f64", "true": self._lanes("i1", "true"),
            "zero": number(0.0), "one": number(1.0), "shift": number(ROUND + 1023.0), "bias": number(2.0**52 + 1023.0),
            "i52": integer(52), "i2047": integer(0x7FF), "fraction": integer(0xFFFFFFFFFFFFF),
            "bits_of_1": integer(bits(1.0)), "bits_of_2_52": integer(bits(2.0**52)),
        }  # fmt: skip
        forms = {**FORMS, "as number": AS_NUMBER, "as flag": AS_FLAG, "read": READ, "write": WRITE}
        self.forms = {op: _partly(form, words) for op, form in forms.items()}

    def number(self, x: float) -> str:
        """A number in all lanes."""
        u = bits(x)
        if u not in self._numbers:
            self._numbers[u] = self._lanes("double", f"0x{u:016X}")
        return self._numbers[u]

    def _type(self, kind: str) -> str:
        return kind if self.width == 1 else f"<{self.width} x {kind}>"

    def _lanes(self, kind: str, value: object) -> str:
        return str(value) if self.width == 1 else f"<{', '.join([f'{kind} {value}'] * self.width)}>"


@functools.cache
def _written(width: int) -> _Width:
    return _Width(width)


def _partly(form: str, words: Mapping[str, str]) -> str:
    """A form in which these words are filled in, and result and operands are not."""
    for name, text in words.items():
        form = form.replace(f"{{{name}}}", text)
    return form


class _Body:
    """The instructions of one function.

    Inputs are read where they are first used and outputs written as soon as they are known, so that few values wait
    in registers.
    """

    def __init__(self, graph: Graph, width: _Width) -> None:
        self.graph, self.width = graph, width
        self.lines: list[str] = []
        self.rank = {place: n for n, place in enumerate(graph.inputs)}
        self._numbers: dict[int, str] = {}  # places as numbers, by what they are called
        self._flags: dict[int, str] = {}

    def put(self, op: str, result: str, *operands: object) -> str:
        """Add an operation; returns its result."""
        self.lines.append(self.width.forms[op].format(*operands, r=result))
        return result

    def add(self, place: int) -> None:
        """Compute the operation of a place."""
        op, operands = self.graph.ops[place], self.graph.operands[place]
        if op == "number":
            self._numbers[place] = self.width.number(self.graph.numbers[place])
        elif op == "input":
            self._numbers[place] = self.put("read", f"%x{place}", self.rank[place])
        else:
            flags = LOGICAL.get(op, 0)
            values = [*map(self.flag, operands[:flags]), *map(self.number, operands[flags:])]
            (self._flags if op in FLAGS else self._numbers)[place] = self.put(op, f"%x{place}", *values)

    def number(self, place: int) -> str:
        """What holds the value of a place; a flag is 1 or 0."""
        if place not in self._numbers:
            self._numbers[place] = self.put("as number", f"%n{place}", self._flags[place])
        return self._numbers[place]

    def flag(self, place: int) -> str:
        """What holds a place as true or false; a number is true unless it is 0."""
        if place not in self._flags:
            self._flags[place] = self.put("as flag", f"%f{place}", self._numbers[place])
        return self._flags[place]


def _used(graph: Graph, live: Iterable[int]) -> list[int]:
    """Places in the order in which they are computed: inputs and numbers just before their first use."""
    order: dict[int, None] = {}
    late = {place for place in live if graph.ops[place] in ("input", "number")}
    for place in live:
        if place not in late:
            order.update(dict.fromkeys(k for k in graph.operands[place] if k in late))
            order[place] = None
    order.update(dict.fromkeys(sorted(late)))  # those that are outputs as they are
    return list(order)


def _function(graph: Graph, name: str, outputs: Sequence[Operand], width: _Width) -> str:
    body = _Body(graph, width)
    rows: dict[int, list[int]] = {}
    for n, x in enumerate(outputs):
        rows.setdefault(graph.place(x), []).append(n)
    for place in _used(graph, graph.live(outputs)):
        body.add(place)
        for n in rows.get(place, ()):
            body.put("write", f"%out{n}", body.number(place), n)
    head = f"define void @{name}({PARAMETERS}) nounwind {{"
    begin = ["br label %next", "next:", "%i = phi i64 [0, %0], [%j, %next]"]
    end = [f"%j = add i64 %i, {width.width}", "%more = icmp ult i64 %j, %n", "br i1 %more, label %next, label %done"]
    return "\n".join([head, *begin, *body.lines, *end, "done:", "ret void", "}\n"])


def functions_text(graph: Graph, functions: Mapping[str, Sequence[Operand]], width: int) -> str:
    """LLVM's intermediate form of functions of a graph of exact operations, for `compile`, by name.

    Each is `void name(ptr in, i64 a, ptr out, i64 b, i64 n)`: `in` holds the inputs of the graph as rows (n_in, n) of
    doubles, whose starts are `a` doubles apart, `out` takes the outputs (n_out, n), `b` apart; flags come out as 1 or
    0.  n is a positive multiple of the width.  The two must not overlap.  They may stand at any multiple of 8 bytes;
    multiples of 64 are fastest.
    """
    written = _written(width)
    return "\n".join(_function(graph, name, outputs, written) for name, outputs in functions.items())


def instructions(graph: Graph, outputs: Sequence[Operand], arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Instructions for one sample whose inputs have these names, and what they call the outputs, as numbers.

    The graph must be of exact operations alone.
    """
    body = _Body(graph, _written(1))
    body._numbers = dict(zip(graph.inputs, arguments, strict=True))
    for place in graph.live(outputs):
        if graph.ops[place] != "input":
            body.add(place)
    return body.lines, [body.number(graph.place(x)) for x in outputs]


# ---------------------------------------------------------------- machine code
class MachineCode:
    """Compiled functions.  Their addresses are valid as long as this object lives."""

    def __init__(self, engine: Any, names: Iterable[str]) -> None:
        self._engine = engine
        self.addresses = {name: int(engine.get_function_address(name)) for name in names}
        missing = [name for name, address in self.addresses.items() if not address]
        if missing:
            raise ValueError(f"machine code without {', '.join(missing)}")

    def function(self, name: str, *kinds: Any) -> Callable[..., None]:
        """A void function to be called from Python, which keeps the code alive; without kinds as `functions_text` says.

        Other threads run while it does.
        """
        types = kinds or (ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64)
        return functools.partial(self._call, ctypes.CFUNCTYPE(None, *types)(self.addresses[name]))

    def _call(self, entry: Callable[..., None], *arguments: object) -> None:
        entry(*arguments)


def host() -> tuple[str, str]:
    """Name and features of this machine's processor, as LLVM calls them."""
    binding = _jit().ready()
    return binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()


def width() -> int:
    """Samples side by side that fill a vector register of this machine: 8 with AVX-512, 4 with AVX, else 2."""
    features = host()[1].split(",")
    return 8 if "+avx512f" in features else 4 if "+avx" in features else 2


def compile(text: str | Callable[[], str], names: Sequence[str], origin: str = "") -> MachineCode:
    """Machine code of the functions in a text, for this machine; from the cache folder if it is there.

    names: the functions that are called from outside.  origin: all that a text depends on which is to be written only
    if its code is not there; what this module makes of it need not be part of it.  The text may call the intrinsics
    fabs, sqrt and floor and must not declare them.  Raises RuntimeError, with LLVM's message,
    for a text that is no code.
    """
    machine = host()
    source = text if isinstance(text, str) else (origin, _own())
    about = (
        source,
        *names,
        *machine,
        LEVEL,
        importlib.import_module("llvmlite").__version__,
        _jit().ready().llvm_version_info,
    )
    key = hashlib.sha256(repr(about).encode()).hexdigest()
    kept = KeptFile(_folder(os.environ.get("RATTLE_CACHE")), FOLDER, key)

    def use(code: tuple[str, bytes]) -> MachineCode:
        if code[0] != key:
            raise ValueError("the code of another text")
        if kept.file is not None:
            with suppress(OSError):
                os.utime(kept.file)  # used just now
        return _loaded(code[1], names, machine)

    code = kept.read(use)
    if isinstance(code, MachineCode):
        return code
    object_code = _object(text if isinstance(text, str) else text(), machine)
    kept.write(lambda: pickle.dumps((key, object_code)))
    if kept.file is not None:
        _keep_most(kept.file.parent)
    return _loaded(object_code, names, machine)


@functools.cache
def _own() -> str:
    """The sources of what writes texts."""
    here = Path(__file__).parent
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(here.glob("llvm*.py")))).hexdigest()


@functools.cache
def _folder(root: str | None) -> Path | None:
    """The folder of kept code, for one value of RATTLE_CACHE."""
    return code_folder(FOLDER).path


def _keep_most(folder: Path) -> None:
    """Remove the code that was not used for longest if there is too much."""
    with suppress(OSError):
        seen = [(entry.stat().st_mtime, entry.stat().st_size, entry) for entry in folder.glob("*.code")]
        size = sum(entry[1] for entry in seen)
        if size > MOST:
            for _, bytes_, file in sorted(seen):
                file.unlink(missing_ok=True)
                size -= bytes_
                if size <= MOST // 2:
                    break


def _machine(cpu: str, features: str) -> Any:
    """LLVM's settings for a processor, for code that is run at once."""
    binding = _jit().ready()
    target = binding.Target.from_triple(binding.get_process_triple())
    where = "static" if target.name.startswith("x86") else "default"
    return target.create_target_machine(cpu=cpu, features=features, opt=LEVEL, reloc=where, jit=True)


def _jit() -> ModuleType:
    """The module that knows LLVM, which it imports."""
    return importlib.import_module("rattle.jit.machine")


def _declared(text: str) -> str:
    """A text with the declarations of the intrinsics that it calls."""
    return "\n".join([*sorted({f"declare {kind} {name}({kind})" for kind, name in DECLARED.findall(text)}), text])


def _object(text: str, machine: tuple[str, str]) -> bytes:
    """The object code of a text."""
    return bytes(_machine(*machine).emit_object(_jit().parsed(_declared(text))))


def _loaded(object_code: bytes, names: Sequence[str], machine: tuple[str, str]) -> MachineCode:
    """Object code as functions.

    The engine's own module is empty and in the context that LLVM keeps until the end: the collector may take engines
    apart in any order, and a context that goes before its engine would end the process.
    """
    binding = _jit().ready()
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _machine(*machine))
    engine.add_object_file(binding.ObjectFileRef.from_data(object_code))
    engine.finalize_object()
    return MachineCode(engine, names)
