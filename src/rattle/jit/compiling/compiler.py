"""The fast way to machine code.  It imports Numba, so it is imported only when machine code is needed.

Numba compiles every function separately and includes the finished code of all functions it calls, at every level.
Here a function that is called by another compiled function remains a *part*, intermediate code that is not optimised;
a *whole*, called from Python or by its address, is linked with all parts it needs and compiled to machine code once.
With `blocks` and `passes` this reduces the time to compile what a run of the four-bar needs from 21 s, the plain way,
to 6 s.

Uses internals of Numba (`CompilerBase`, `CodeLibrary`): only for the versions in `compile_path`.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
from numba import types
from numba.core import typed_passes, typing, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass

from rattle.jit import machine
from rattle.jit.cache import CodeCache
from rattle.jit.compiling import passes
from rattle.jit.compiling.blocks import BLOCKS, block
from rattle.jit.compiling.numba_types import OPTIONS, signature

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"

log = logging.getLogger("rattle")
lock = global_compiler_lock
ARRAY_TYPES = BLOCKS
OURS = {**OPTIONS, "no_cfunc_wrapper": True, "_nrt": False}  # our functions allocate no arrays: no reference counting


# ---------------------------------------------------------------- code libraries
class _Library(JITCodeLibrary):
    """Code of a function, optimised after it is linked."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def add_ir_module(self, module: Any) -> None:
        """Take over the code of a module, and empty it: its instructions refer to each other in circles."""
        super().add_ir_module(module)
        for function in module.functions:
            for one in function.blocks:
                one.instructions.clear()
                one.terminator = None
            function.blocks.clear()


class _Part(_Library):
    """Intermediate code of one function."""

    def finalize(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "linkonce_odr"  # may be linked more than once, and dropped once inlined
        self._shared_module = self._final_module
        self._finalized = True


class _Whole(_Library):
    """Machine code of one function with all its parts."""

    def _optimize_final_module(self) -> None:
        """Optimise at level 1: a tenth faster than Numba's two rounds, at 0 and 3, and the code runs as fast."""
        made = self._codegen._module_pass_manager(opt=1)
        manager, *builder = made if isinstance(made, tuple) else (made,)  # in old versions only the manager
        manager.run(self._final_module, *builder)

    def finalize(self) -> None:
        found: dict[Any, None] = {}
        ahead = list(self._linking_libraries)
        while ahead:
            library = ahead.pop()
            if library not in found:
                found[library] = None
                ahead += library._linking_libraries if isinstance(library, _Part) else ()
        self._linking_libraries: list[Any] = list(found)
        super().finalize()


class _Object(_Whole):
    """The same as an object file, which is not loaded into memory."""

    def _finalize_final_module(self) -> None:
        options = {"opt": 1}
        self._codegen._customize_tm_options(options)
        target = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(**options)
        self.object_file = bytes(target.emit_object(self._final_module))
        self._finalized = True


# ---------------------------------------------------------------- compilers
_said: list[str] = []


def _say_once() -> None:
    """Tell the user, once, that something is being compiled and not just read from the cache."""
    if not _said:
        _said.append("compiling kernels (once)")
        log.info(_said[0])


def _lower_to(library: type[_Library]) -> Any:
    """The compiler pass that produces intermediate code, as a library of this class."""

    @register_pass(mutates_CFG=True, analysis_only=False)
    class Lower(typed_passes.NativeLowering):
        _name = f"rattle{library.__name__}"

        def run_pass(self, state: Any) -> Any:
            state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
            return super().run_pass(state)

        @property
        def lowering_class(self) -> Any:
            return passes.Lower

    return Lower


class _Compiler(CompilerBase):
    """Numba's pipeline without what our functions do not need: closures, array expressions, reference counts."""

    lower: Any

    def define_pipelines(self) -> list[PassManager]:
        _say_once()
        manager = PassManager("rattle")
        for one in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            passes.Simplify,
            passes.AssignOnce,
            passes.Types,
            passes.StripPhis,
            self.lower,
            typed_passes.NoPythonBackend,
            passes.Forget,
        ):
            manager.add_pass(one, one._name)
        manager.finalize()
        return [manager]


class _WholeCompiler(_Compiler):
    lower = _lower_to(_Whole)


class _PartCompiler(_Compiler):
    lower = _lower_to(_Part)

    def define_pipelines(self) -> list[PassManager]:
        self.state.flags.no_compile = True
        return super().define_pipelines()


class _ObjectCompiler(_PartCompiler):
    lower = _lower_to(_Object)


def part(function: Callable[..., Any]) -> Any:
    """A dispatcher for calls from compiled functions: one version for given argument types, not for their values."""
    dispatcher = numba.njit(pipeline_class=_PartCompiler, no_cpython_wrapper=True, **OURS)(function)
    made: dict[Any, Any] = {}

    def template(arguments: Any, named: Any) -> Any:
        given = tuple(block(types.unliteral(one)) for one in arguments)
        by_name = {name: block(types.unliteral(one)) for name, one in named.items()}
        parameters, given = dispatcher.fold_argument_types(given, by_name)
        if given not in made:
            result = dispatcher._compiler.compile(given, None)
            result.target_context.insert_user_function(result.fndesc.mangled_name, result.fndesc, [result.library])
            made[given] = result
        name = function.__name__
        found = typing.make_concrete_template(name, key=name, signatures=[one.signature for one in made.values()])
        return found, parameters, given, {}

    dispatcher.get_call_template = template
    dispatcher.get_overload = lambda arguments: made[tuple(arguments)].fndesc.mangled_name
    return dispatcher


def whole(function: Callable[..., Any], letters: Sequence[str], cache: CodeCache | None = None) -> Any:
    """A dispatcher for calls from Python; with letters, compiled now for that signature, and callable by address."""
    dispatcher = numba.njit(pipeline_class=_WholeCompiler, **OURS)(function)
    if cache is not None:
        dispatcher._cache = cache
    if letters:
        dispatcher.compile(signature(letters, BLOCKS))
        dispatcher.disable_compile()
    return dispatcher


def foreign(function: Callable[..., Any], letters: Sequence[str]) -> Any:
    """A dispatcher for a function of the user, with all features of Numba; compiled at once."""
    return numba.njit(signature(letters), **OPTIONS)(function)


def native(function: Callable[..., Any], letters: Sequence[str]) -> machine.Code:
    """Machine code of a function with fixed types, to be called by its address."""
    dispatcher = numba.njit(pipeline_class=_ObjectCompiler, no_cpython_wrapper=True, **OURS)(function)
    wanted = signature(letters, BLOCKS)
    result = dispatcher._compiler.compile(wanted.args, wanted.return_type)
    library = result.library
    library._ensure_finalized()
    needs = sorted(
        one.name for one in _symbols(library._final_module) if one.is_declaration and not one.name.startswith("llvm.")
    )
    return machine.Code(result.fndesc.llvm_func_name, library.object_file, tuple(needs))


def _symbols(module: Any) -> Iterator[Any]:
    yield from module.functions
    yield from module.global_variables


def check() -> None:
    """Compile two small functions, one of which calls the other.  Raises whatever this version of Numba raises."""
    double = part(_double)

    def next_to(table: Any, k: int) -> Any:
        found = math.inf
        for n in range(table.shape[0]):
            if n == k:
                found = double(table[n], k)
        return found + 1.0

    call = machine.caller("next_to", machine.load(native(next_to, CHECKED)), CHECKED)
    if call(np.array([[0.0, 1.0], [2.0, 3.0]]), 1) != 7.0:
        raise RuntimeError("a small function gives a wrong number")


CHECKED = ("f", "m", "i")


def _double(row: Any, k: int) -> Any:
    return 2.0 * row[k]
