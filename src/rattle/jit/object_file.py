"""An object file for this platform: all kernels that some functions reach, to be linked with a program in C.

What is offered as "run.begin" is `int32_t rattle_run_begin(void *result, ...)`; see `linking` for how it is called.
`rattle_kernels` and `rattle_traps` hold what stands for kernels, and where there is none, in the tables of a workspace,
in the order of `Linked.kernels` and of `families.SIGNATURE`.  The program has `void rattle_fault(const char *text)`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import llvmlite.binding as llvm

from rattle.jit import families, machine
from rattle.jit.linking import Linked
from rattle.jit.machine import ARRAYS
from rattle.jit.translation.unit import ABOUT

FAULT = "rattle_fault"
MISSING = f"""declare void @{FAULT}(ptr)
declare void @llvm.trap()
define internal i64 @"{machine.FIND}"(i64 %place) noinline cold {{
  call void @llvm.trap()
  unreachable
}}"""


def symbol(offered: str) -> str:
    """The name in C of a function that is offered."""
    return f"rattle_{offered.replace('.', '_')}"


def prototype(offered: str, letters: Sequence[str]) -> str:
    """The declaration in C of a function that is offered, with RATTLE_HIDDEN.  letters: see `families.SIGNATURE`."""
    parameters = ["void *result"]
    for letter in letters[1:]:
        if letter in ARRAYS:
            dtype, dimensions = ARRAYS[letter]
            parameters += [f"{'double' if dtype.kind == 'f' else 'int64_t'} *", *["int64_t"] * dimensions]
        else:
            parameters.append({"h": "void *", "f": "double", "i": "int64_t"}[letter])
    return f"RATTLE_HIDDEN int32_t {symbol(offered)}({', '.join(parameters)});"


def object_file(linked: Linked) -> bytes:
    """Machine code of linked functions for any processor of this platform, to be loaded anywhere."""
    text = linked.text.replace(f'@"{machine.FAULT}"', f"@{FAULT}")
    for name in linked.offered:
        text = text.replace(f'@"call.{name}"', f"@{symbol(name)}")
    text = re.sub(r"^define (?=i32 @rattle_)", "define hidden ", text, flags=re.MULTILINE)
    kernels = [
        f"{'rattle.place' if family in families.BY_PLACE else 'code.rattle.place'}{place.removeprefix('rattle.place')}"
        for place, family in linked.kernels.items()
    ]
    tables = [
        _table("rattle_kernels", kernels),
        _table("rattle_traps", [f"trap.{family}" for family in families.SIGNATURE]),
    ]
    module = machine.parsed("\n".join([MISSING, text, *tables, ABOUT]))
    target = machine.ready().Target.from_triple(llvm.get_process_triple()).create_target_machine(opt=2, reloc="pic")
    module.triple, module.data_layout = llvm.get_process_triple(), str(target.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(target, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(target.emit_object(module))


def _table(name: str, functions: Iterable[str]) -> str:
    every = [f'ptr @"{function}"' for function in functions]
    return f"@{name} = hidden constant [{len(every)} x ptr] [{', '.join(every)}]"
