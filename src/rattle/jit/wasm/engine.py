"""An engine: all kernels that some functions reach, as one WebAssembly module.

Functions are called as in `linking`.  Kernels that stand in the tables of a workspace are known by name: the section
`rattle` of the module says what stands for each in a table.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import re
from collections.abc import Mapping

import llvmlite.binding as llvm

from rattle.jit import families, machine
from rattle.jit.columns import COLUMNS
from rattle.jit.linking import Linked
from rattle.jit.translation.unit import ABOUT
from rattle.jit.wasm import binary
from rattle.jit.workspace import ARRAYS
from rattle.value_types import Json

SECTION = "rattle"  # of the module: what it offers, as JSON
TRIPLE = "wasm32-unknown-unknown"
# bulk memory fills arrays with zeros without a function for it; conversions to integers do not trap
FEATURES = "+bulk-memory,+nontrapping-fptoint,+sign-ext,+mutable-globals"
STACK = 128 * 1024  # bytes
TOLD = "rattle.told"  # place in memory of the address of the text of the last error
LIBRARY = re.compile(r'^declare double @"(\w+)"\([^)]*\).*$', re.MULTILINE)
INTRINSICS = {
    f"llvm.{name}.f64": f"declare double @llvm.{name}.f64({', '.join(['double'] * count)})"
    for name, count in (("fabs", 1), ("floor", 1), ("sqrt", 1), ("copysign", 2))
}
REMAINDER = re.compile(r"frem double (\S+), (\S+)")


def layout() -> str:
    """What a workspace is in memory, as a short text: another one means another engine."""
    about = (
        [(name, array.kind) for name, array in ARRAYS.items()],
        {name: len(columns) for name, columns in COLUMNS.items()},
    )
    return hashlib.sha256(repr((about, families.SIGNATURE, families.BY_PLACE)).encode()).hexdigest()[:16]


# ---------------------------------------------------------------- text
def whole_text(linked: Linked, library: str) -> str:
    """The text of an engine.

    library: text of the functions "rattle.sin" and the like, and of "rattle.fmod", for those that kernels call.
    """
    slots = [_slot(symbol, f"code.{symbol}") for symbol in linked.kernels]
    slots += [_slot(f"trap.{family}", f"trap.{family}") for family in families.SIGNATURE]
    text = "\n".join([_first(), _with_library(linked.text), *slots, library, ABOUT])
    return text + "\n".join(line for name, line in INTRINSICS.items() if f'@"{name}"' not in linked.text)


def _with_library(text: str) -> str:
    """A text that calls the package's own library."""
    for name in sorted(set(LIBRARY.findall(text))):
        text = re.sub(rf'^declare double @"{name}"\(.*$\n?', "", text, flags=re.MULTILINE)
        text = text.replace(f'call double @"{name}"(', f'call double @"rattle.{name}"(')
    return REMAINDER.sub(r'call double @"rattle.fmod"(double \1, double \2)', text)


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
def _optimised(text: str, target: llvm.TargetMachine) -> llvm.ModuleRef:
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


def engine(linked: Linked, library: str, more: Mapping[str, Json]) -> bytes:
    """The WebAssembly module of linked functions; the same text gives the same bytes.

    library: see `whole_text`.  more: what it says of itself besides.
    """
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple(TRIPLE).create_target_machine(opt=2, features=FEATURES, reloc="static")
    linked_module = binary.linked(bytes(target.emit_object(_optimised(whole_text(linked, library), target))))
    if linked_module.symbols["rattle.nothing"].value != 0:
        raise binary.BrokenModule("something stands at address 0 of the engine")
    numbers = {symbol: _number(linked_module, symbol, family) for symbol, family in linked.kernels.items()}
    told = {
        "layout": layout(),
        "llvmlite": importlib.import_module("llvmlite").__version__,
        "calls": {name: list(letters) for name, letters in linked.offered.items()},
        "arrays": [[name, array.kind] for name, array in ARRAYS.items()],
        "kernels": numbers,
        "traps": {family: _number(linked_module, f"trap.{family}", family) for family in families.SIGNATURE},
        "told": linked_module.symbols[TOLD].value,
        **more,
    }
    offered = {f"call {name}": f"call.{name}" for name in linked.offered}
    told["free"] = binary.top(linked_module, STACK)
    section = binary.custom(SECTION, json.dumps(told, separators=(",", ":")).encode())
    return binary.module(linked_module, offered, STACK, [section])


def _number(linked_module: binary.Linked, name: str, family: str) -> int:
    """What stands for a kernel of a family in tables."""
    slot = linked_module.symbols[f"slot.{name}"].value
    return slot if family in families.BY_PLACE else linked_module.word(slot)


def about(module: bytes) -> dict[str, Json]:
    """What an engine says of itself.  Raises BrokenModule for another module."""
    custom = binary.custom_sections(module)
    if SECTION not in custom:
        raise binary.BrokenModule("this WebAssembly module is no engine of rattle")
    told: dict[str, Json] = json.loads(custom[SECTION])
    return told
