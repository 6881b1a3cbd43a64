"""An engine: all kernels that some functions reach, as one WebAssembly module.

Functions are called as everywhere, see `machine`: with the place of the result, then numbers, addresses and shapes;
they return 0, or 1 if they failed.  Kernels that stand in the tables of a workspace are known by name: the section
`rattle` of the module says what stands for each in a table.  Calls of other natives, which machine code makes by a
place that the linker knows, become calls of the function itself.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from rattle.jit import families, functions, machine
from rattle.jit.columns import COLUMNS
from rattle.jit.functions import KernelFunction
from rattle.jit.translation.calls import kinds_of
from rattle.jit.translation.unit import ABOUT, Unit, function, told_where
from rattle.jit.translation.values import parts_of
from rattle.jit.wasm import binary
from rattle.jit.workspace import ARRAYS

SECTION = "rattle"  # of the module: what it offers, as JSON
TRIPLE = "wasm32-unknown-unknown"
# bulk memory fills arrays with zeros without a function for it; conversions to integers do not trap
FEATURES = "+bulk-memory,+nontrapping-fptoint,+sign-ext,+mutable-globals"
STACK = 128 * 1024  # bytes
TOLD = "rattle.told"  # place in memory of the address of the text of the last error
MISSING = "a kernel of the family '{}' was called, but it is not in the table of this workspace"
LIBRARY = re.compile(r'^declare double @"(\w+)"\([^)]*\).*$', re.MULTILINE)
INTRINSICS = {
    f"llvm.{name}.f64": f"declare double @llvm.{name}.f64({', '.join(['double'] * count)})"
    for name, count in (("fabs", 1), ("floor", 1), ("sqrt", 1), ("copysign", 2))
}
REMAINDER = re.compile(r"frem double (\S+), (\S+)")


class Linked(NamedTuple):
    """Functions that need nothing but each other, in LLVM's language."""

    text: str
    offered: dict[str, tuple[str, ...]]  # name: letters of result and arguments, see `families.SIGNATURE`
    kernels: dict[str, str]  # family by symbol, of what stands in tables


# ---------------------------------------------------------------- convention
def called(unit: Unit, name: str, one: KernelFunction, letters: Sequence[str]) -> str:
    """The text of a function as others call it by its address."""
    result, kinds = kinds_of(letters)
    made = function(unit, one.python, kinds)
    return told_where(made, lambda: made.written(name, outer=result))


def trap(family: str) -> str:
    """The text of what stands in tables where there is no kernel: it fails, and says which family was called."""
    _, kinds = kinds_of(families.SIGNATURE[family])
    types = ["ptr", *(type_ for kind in kinds for type_ in parts_of(kind))]
    name, words = f"trap.{family}", f"RuntimeError: {MISSING.format(family)}"
    return f"""@"words.{name}" = private constant [{len(words) + 1} x i8] c"{words}\\00"
define internal i32 @"{name}"({", ".join(types)}) noinline cold {{
  call void @"{machine.FAULT}"(ptr @"words.{name}")
  ret i32 1
}}
{_slot(name, name)}"""


def layout() -> str:
    """What a workspace is in memory, as a short text: another one means another engine."""
    about = [(name, one.kind) for name, one in ARRAYS.items()], {name: len(one) for name, one in COLUMNS.items()}
    return hashlib.sha256(repr((about, families.SIGNATURE, families.BY_PLACE)).encode()).hexdigest()[:16]


# ---------------------------------------------------------------- linking
def link(
    offered: Mapping[str, tuple[KernelFunction, Sequence[str]]], kernels: Iterable[KernelFunction], library: str
) -> Linked:
    """The text of all that these functions and kernels reach.

    offered: by name, with the letters of result and arguments.  kernels: those that may stand in tables.  library: text
    of the functions "rattle.sin" and the like, and of "rattle.fmod", that kernels call.  Raises TranslationError for
    what kernels cannot use.
    """
    unit, texts = Unit(), []
    table = sorted(kernels, key=lambda one: one.symbol)
    for name, (one, letters) in sorted(offered.items()):
        texts.append(called(unit, f"call.{name}", one, letters))
    natives = {one.symbol: one for one in functions.natives()}
    done: set[str] = set()
    ahead = {one.symbol for one in table} | _places(unit)
    while ahead:
        for symbol in sorted(ahead):
            text = called(unit, f"code.{symbol}", natives[symbol], natives[symbol].letters)
            texts.append(text.replace("define i32", "define internal i32", 1))
        done |= ahead
        ahead = _places(unit) - done
    whole = unit.whole("\n".join(texts)).replace(ABOUT, "")
    slots = [_slot(one.symbol, f"code.{one.symbol}") for one in table]
    traps = [trap(family) for family in families.SIGNATURE]
    text = "\n".join([_first(), _own_places(whole, done), *slots, *traps, library, ABOUT])
    text += "\n".join(line for name, line in INTRINSICS.items() if f'@"{name}"' not in whole)
    return Linked(
        text, {name: tuple(offered[name][1]) for name in sorted(offered)}, {k.symbol: k.family for k in table}
    )


def _places(unit: Unit) -> set[str]:
    """Symbols of all natives that the functions of a unit call."""
    found, seen, ahead = set(unit.declared), set(), list(unit.parts.values())
    while ahead:
        part = ahead.pop()
        if part.name not in seen:
            seen.add(part.name)
            found |= set(part.unit.declared)
            ahead += part.unit.parts.values()
    return {name for name in found if name.startswith("rattle.place.")}


def _own_places(text: str, symbols: Iterable[str]) -> str:
    """A text whose places hold the functions that they stand for, and that calls the package's own library."""
    places = [f'@"{one}" = internal constant i64 ptrtoint (ptr @"code.{one}" to i64)' for one in sorted(symbols)]
    lines = [line for line in text.split("\n") if not line.endswith(" = external global i64")]
    lines = [line for line in lines if not line.startswith((f'declare i64 @"{machine.FIND}"', 'declare void @"rattle'))]
    text = "\n".join(lines)
    for name in sorted(set(LIBRARY.findall(text))):
        text = re.sub(rf'^declare double @"{name}"\(.*$\n?', "", text, flags=re.MULTILINE)
        text = text.replace(f'call double @"{name}"(', f'call double @"rattle.{name}"(')
    text = REMAINDER.sub(r'call double @"rattle.fmod"(double \1, double \2)', text)
    return "\n".join([*places, text])


def _first() -> str:
    """What every engine has: nothing at address 0, and where errors are told."""
    return f"""@"rattle.nothing" = constant [2 x i64] zeroinitializer, align 16
@"{TOLD}" = global i32 0
define internal void @"{machine.FAULT}"(ptr %text) noinline cold {{
  %place = ptrtoint ptr %text to i64
  %short = trunc i64 %place to i32
  store i32 %short, ptr @"{TOLD}"
  ret void
}}
define internal i64 @"{machine.FIND}"(i64 %place) noinline cold {{
  call void @llvm.trap()
  unreachable
}}
declare void @llvm.trap()"""


def _slot(name: str, function: str) -> str:
    """The number of a function that may stand in a table, in memory: of eight bytes, as a place holds it."""
    return f'@"slot.{name}" = global {{ i32, i32 }} {{ i32 ptrtoint (ptr @"{function}" to i32), i32 0 }}, align 8'


# ---------------------------------------------------------------- compiling
def _optimised(text: str, target: Any) -> Any:
    """A module of a text, for WebAssembly.

    Without `optsize` it is a sixth larger and 4 % faster, with level 3 and loops unrolled a fifth larger and as fast.
    """
    module = machine.parsed(
        re.sub(
            r"^attributes (#\d) = { nounwind( alwaysinline)?", r"attributes \1 = { nounwind optsize", text, flags=re.M
        )
    )
    module.triple, module.data_layout = TRIPLE, str(target.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(target, options)
    builder.getModulePassManager().run(module, builder)
    return module


def engine(linked: Linked, more: Mapping[str, Any]) -> bytes:
    """The WebAssembly module of linked functions; the same text gives the same bytes.

    more: what it says of itself besides.
    """
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple(TRIPLE).create_target_machine(opt=2, features=FEATURES, reloc="static")
    made = binary.linked(bytes(target.emit_object(_optimised(linked.text, target))))
    if made.symbols["rattle.nothing"].value != 0:
        raise binary.BrokenModule("something stands at address 0 of the engine")
    numbers = {symbol: _number(made, symbol, family) for symbol, family in linked.kernels.items()}
    told = {
        "layout": layout(),
        "llvmlite": importlib.import_module("llvmlite").__version__,
        "calls": {name: list(letters) for name, letters in linked.offered.items()},
        "arrays": [[name, one.kind] for name, one in ARRAYS.items()],
        "kernels": numbers,
        "traps": {family: _number(made, f"trap.{family}", family) for family in families.SIGNATURE},
        "told": made.symbols[TOLD].value,
        **more,
    }
    offered = {f"call {name}": f"call.{name}" for name in linked.offered}
    told["free"] = binary.top(made, STACK)
    section = binary.custom(SECTION, json.dumps(told, separators=(",", ":")).encode())
    return binary.module(made, offered, STACK, [section])


def _number(made: binary.Linked, name: str, family: str) -> int:
    """What stands for a kernel of a family in tables."""
    slot = made.symbols[f"slot.{name}"].value
    return slot if family in families.BY_PLACE else made.word(slot)


def about(module: bytes) -> dict[str, Any]:
    """What an engine says of itself.  Raises BrokenModule for another module."""
    found = binary.custom_sections(module)
    if SECTION not in found:
        raise binary.BrokenModule("this WebAssembly module is no engine of rattle")
    told: dict[str, Any] = json.loads(found[SECTION])
    return told
