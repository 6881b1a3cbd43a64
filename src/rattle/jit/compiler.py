"""How our functions become machine code.  Imports Numba: only to be imported once machine code is wanted.

Numba compiles every function by itself and puts the finished code of all functions it calls into it once more, down
to the last.  Here a function that is called by another compiled function stays a *part*, intermediate code that
nobody optimises; a *whole*, called from Python or by its address, is linked with all parts it needs and made into
machine code once.  With arrays.py this brought the time to compile everything, in one process, from 53 s to 24 s.

Written against the compiler pipeline of Numba 0.61 to 0.68 (`CompilerBase`, `CodeLibrary`); see pyproject.toml.
"""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils, typed_passes, typing, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.registry import cpu_target
from numba.core.typing.templates import ConcreteTemplate
from numba.extending import lower_builtin, type_callable
from numba.np.unsafe.ndarray import to_fixed_tuple

from rattle.jit import machine
from rattle.jit.blocks import MATRIX, VECTOR, WHOLE_ROWS, WORKSPACE, block
from rattle.jit.cache import CodeCache

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"

log = logging.getLogger("rattle")
lock = global_compiler_lock
OPTIONS = {"nogil": True, "error_model": "numpy"}
OURS = {**OPTIONS, "no_cfunc_wrapper": True, "_nrt": False}  # our functions make no arrays: nothing to count
WHOLE_NUMBER = ir.IntType(64)
TYPES = {
    "void": types.void,
    "i": types.int64,
    "f": types.float64,
    "v": VECTOR,
    "m": MATRIX,
    "h": WORKSPACE,
    "n": WHOLE_ROWS,
}


def signature(letters: Sequence[str], plain: bool = False) -> Any:
    """Numba's signature for a result and arguments, one letter each; with Numba's own arrays if `plain`.

    A result of several letters is a tuple.
    """
    first, *arguments = (TYPES.get(x, x) for x in letters)
    result = types.BaseTuple.from_types([TYPES[x] for x in first]) if isinstance(first, str) else first
    if plain:
        arguments = [types.Array(x.dtype, x.ndim, "C") if isinstance(x, types.Array) else x for x in arguments]
    return result(*arguments)


@contextmanager
def settings() -> Iterator[None]:
    """An optimiser level that compiles a tenth faster to code that runs as fast.

    The collector of garbage rests: compiling makes millions of objects that live on.
    """
    before, collects = numba.config.OPT, gc.isenabled()
    try:
        gc.disable()
        numba.config.OPT = type(before)(1)
        yield
    finally:
        numba.config.OPT = before
        if collects:
            gc.enable()


# ---------------------------------------------------------------- code libraries
class _Library(JITCodeLibrary):
    """Code as it comes from a function; optimised once it is linked."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout


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


# ---------------------------------------------------------------- compilers
_said: list[str] = []


def _say_once() -> None:
    """Tell the user, once, that something is compiled and not just read from the cache."""
    if not _said:
        _said.append("compiling kernels (once)")
        log.info(_said[0])


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerPart(typed_passes.NativeLowering):
    _name = "rattle_part"

    def run_pass(self, state: Any) -> Any:
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().run_pass(state)


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerWhole(typed_passes.NativeLowering):
    _name = "rattle_whole"

    def run_pass(self, state: Any) -> Any:
        state.library = _Whole(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().run_pass(state)


class _Compiler(CompilerBase):
    """Numba's own pipeline less what our functions have no use for: closures, array expressions, literals."""

    lower: Any

    def define_pipelines(self) -> list[PassManager]:
        _say_once()
        manager = PassManager("rattle")
        for one in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            untyped_passes.GenericRewrites,
            untyped_passes.ReconstructSSA,
            typed_passes.NopythonTypeInference,
            typed_passes.PreLowerStripPhis,
            typed_passes.IRLegalization,
            self.lower,
            typed_passes.NoPythonBackend,
        ):
            manager.add_pass(one, one._name)
        manager.finalize()
        return [manager]


class _PartCompiler(_Compiler):
    lower = _LowerPart

    def define_pipelines(self) -> list[PassManager]:
        self.state.flags.no_compile = True
        return super().define_pipelines()


class _WholeCompiler(_Compiler):
    lower = _LowerWhole


def part(function: Callable[..., Any]) -> Any:
    """A dispatcher for calls from compiled functions: one version for the types of arguments, whatever their values."""
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
        dispatcher.compile(signature(letters))
        dispatcher.disable_compile()
    return dispatcher


def foreign(function: Callable[..., Any], letters: Sequence[str]) -> Any:
    """A dispatcher for a function of the user's, with all that Numba can do; compiled now."""
    return numba.njit(signature(letters, plain=True), **OPTIONS)(function)


def native(function: Callable[..., Any], letters: Sequence[str]) -> machine.Code:
    """Machine code of a function with fixed types, to be called by its address."""
    dispatcher = numba.njit(pipeline_class=_WholeCompiler, no_cpython_wrapper=True, **OURS)(function)
    wanted = signature(letters)
    result = dispatcher._compiler.compile(wanted.args, wanted.return_type)
    library = result.library
    needs = sorted(
        one.name for one in _symbols(library._final_module) if one.is_declaration and not one.name.startswith("llvm.")
    )
    return machine.Code(result.fndesc.llvm_func_name, library._get_compiled_object(), tuple(needs))


def _symbols(module: Any) -> Iterator[Any]:
    yield from module.functions
    yield from module.global_variables


def users_law(law: Callable[..., Any], count: int) -> tuple[Any, Any]:
    """A function of the user's, compiled, and one that takes its `count` values from parameters: (p, k) -> tuple."""
    if not isinstance(law, numba.core.dispatcher.Dispatcher):
        law = numba.njit(**OPTIONS)(law)
    return law, numba.njit(lambda p, k: to_fixed_tuple(p[k : k + count], count))


def address(dispatcher: Any) -> int:
    """Native address of a function compiled for one signature."""
    result = dispatcher.get_compile_result(dispatcher.nopython_signatures[0])
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


# ---------------------------------------------------------------- calls of native functions
def by_place(name: str, letters: Sequence[str]) -> Any:
    """Numba's type of a function that calls the native one whose place has this name, see `machine`."""
    wanted = signature(letters)

    def call() -> None:
        """The key of the code that does it."""

    def jump(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.module.globals.get(name) or ir.GlobalVariable(builder.module, WHOLE_NUMBER, name)
        return _jump_to(context, builder, _found(context, builder, place), wanted, args, fails=True)

    template = type(name, (ConcreteTemplate,), {"key": call, "cases": [wanted], "unsafe_casting": False})
    cpu_target.target_context.insert_func_defn([(jump, call, wanted.args)])
    return types.Function(template)


def _found(context: Any, builder: Any, place: Any) -> Any:
    """The address that stands at a place; asked for where there is none yet."""
    known, before = builder.load(place), builder.block
    with cgutils.if_unlikely(builder, builder.icmp_unsigned("==", known, WHOLE_NUMBER(0))):
        asked = ir.FunctionType(WHOLE_NUMBER, [WHOLE_NUMBER])
        find = cgutils.get_or_insert_function(builder.module, asked, machine.FIND)
        made = builder.call(find, [builder.ptrtoint(place, WHOLE_NUMBER)])
        with cgutils.if_unlikely(builder, builder.icmp_unsigned("==", made, WHOLE_NUMBER(0))):
            context.call_conv.return_user_exc(builder, machine.NotMade, ())
        after = builder.block
    address = builder.phi(WHOLE_NUMBER)
    address.add_incoming(known, before)
    address.add_incoming(made, after)
    return address


def _jump_to(context: Any, builder: Any, address: Any, wanted: Any, args: Sequence[Any], fails: bool) -> Any:
    """Call the native function at an address; what it raises is raised, or with `fails` false forgotten."""
    convention = context.call_conv
    pointer = convention.get_function_type(wanted.return_type, wanted.args).as_pointer()
    target = builder.inttoptr(address, pointer)
    status, result = convention.call_function(builder, target, wanted.return_type, wanted.args, args)
    if fails:
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
    return context.get_dummy_value() if wanted.return_type == types.void else result


def jumps(call: Callable[..., Any], letters: Sequence[str], by_place: bool) -> None:
    """Teach Numba that `call(address, arguments)` jumps to the native address of a function of this signature.

    by_place: it is given where the address stands, see `machine`, and what the function raises is raised; else that
    is forgotten, as with a law of the user's.
    A tuple of first-class functions as argument costs 60 us per function and call to unbox
    (Numba 0.68); an address in an integer array costs nothing.
    """
    wanted = signature(letters)

    @type_callable(call)
    def result(context: Any) -> Any:
        return lambda address, arguments: wanted.return_type

    @lower_builtin(call, types.Integer, types.BaseTuple)
    def jump(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        packed = sig.args[1]
        parts = [
            context.cast(builder, builder.extract_value(args[1], n), packed[n], want)
            for n, want in enumerate(wanted.args)
        ]
        address = args[0]
        if by_place:
            address = _found(context, builder, builder.inttoptr(address, WHOLE_NUMBER.as_pointer()))
        return _jump_to(context, builder, address, wanted, parts, fails=by_place)
