"""Passes of the fast way, from Python code to intermediate code, where they do less than those of Numba.

Numba determines the lifetime of every variable five times and marks its end with a statement, for counting references;
it resolves `at.COS` at every use, and takes the truth value of every comparison.  Our functions own no objects and
columns are constants, so none of this is needed: with 0.4 times as many statements the machine code is the same.
"""

from __future__ import annotations

import operator
from types import BuiltinFunctionType, ModuleType
from typing import Any

from numba import types
from numba.core import cgutils, ir, lowering, typed_passes
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.errors import NumbaWarning, WarningsFixer  # type: ignore[attr-defined]
from numba.core.ir_utils import build_definitions
from numba.core.rewrites import rewrite_registry
from numba.core.ssa import reconstruct_ssa
from numba.core.transforms import canonicalize_cfg
from numba.core.typeinfer import TypeInferer

# Numba has no types: its classes and decorators are unknown
# mypy: disable-error-code="untyped-decorator, misc"

COMPARISONS = (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne)


# ---------------------------------------------------------------- before types are known
@register_pass(mutates_CFG=True, analysis_only=False)
class Simplify(FunctionPass):
    """Fold names, and apply Numba's rewrites."""

    _name = "rattle_simplify"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> Any:
        fold(state.func_ir)
        state.func_ir.blocks = canonicalize_cfg(state.func_ir.blocks)  # one way back in every loop, as with Numba
        for kind in rewrite_registry.rewrites["before-inference"]:
            rewrite, ahead = kind(state), list(state.func_ir.blocks.items())
            while ahead:  # until it finds nothing more to do
                label, block = ahead.pop()
                if rewrite.match(state.func_ir, block, state.typemap, state.calltypes):
                    state.func_ir.blocks[label] = rewrite.apply()
                    ahead.append((label, state.func_ir.blocks[label]))
        return True


def fold(code: Any) -> None:
    """Replace attributes of modules by their values, and truth values of comparisons by the comparisons."""
    statements = [one for block in code.blocks.values() for one in block.body]
    idle: set[str] = set()  # variables that may not be needed any more
    for one in statements:
        if isinstance(one, ir.Assign) and isinstance(one.value, ir.Expr) and one.value.op == "getattr":
            owner = _only(code, one.value.value)
            if isinstance(owner, ir.Global) and isinstance(owner.value, ModuleType):
                idle.add(one.value.value.name)
                one.value = _constant(one.value.attr, getattr(owner.value, one.value.attr), one.loc)
        elif isinstance(one, ir.Branch):
            truth = _only(code, one.cond)
            if _is_truth_of_comparison(code, truth):
                idle |= {one.cond.name, truth.func.name}
                one.cond = truth.args[0]
    _drop(code, idle)
    code._definitions = build_definitions(code.blocks)


def _only(code: Any, variable: Any) -> Any:
    """What is assigned to a variable, if that is done once."""
    found = code._definitions.get(variable.name, ())
    return found[0] if len(found) == 1 else None


def _constant(name: str, value: Any, loc: Any) -> Any:
    return ir.Const(value, loc, use_literal_type=False) if type(value) in (int, float) else ir.Global(name, value, loc)


def _is_truth_of_comparison(code: Any, value: Any) -> bool:
    if not isinstance(value, ir.Expr) or value.op != "call" or len(value.args) != 1:
        return False
    function, given = _only(code, value.func), _only(code, value.args[0])
    compares = isinstance(given, ir.Expr) and given.op == "binop" and given.fn in COMPARISONS
    return compares and isinstance(function, ir.Global) and function.value is bool


def _drop(code: Any, idle: set[str]) -> None:
    """Remove the assignments to these variables where nothing reads them."""
    doubtful: list[Any] = []
    used: set[str] = set()
    for block in code.blocks.values():
        for one in block.body:
            if isinstance(one, ir.Assign) and one.target.name in idle:
                doubtful.append(one)
            else:
                used.update(variable.name for variable in one.list_vars())
    dropped = set()
    for one in reversed(doubtful):
        if one.target.name in used:
            used.update(variable.name for variable in one.list_vars())
        else:
            dropped.add(id(one))
    for block in code.blocks.values():
        block.body = [one for one in block.body if id(one) not in dropped]


@register_pass(mutates_CFG=False, analysis_only=False)
class AssignOnce(FunctionPass):
    """Static single assignment."""

    _name = "rattle_assign_once"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> Any:
        state.func_ir = reconstruct_ssa(state.func_ir)
        state.func_ir._definitions = build_definitions(state.func_ir.blocks)
        return True


# ---------------------------------------------------------------- types
class _Inference(TypeInferer):
    """Numba's type inference, which looks up a call with the same types only once."""

    def resolve_call(self, function: Any, given: Any, named: Any) -> Any:
        """The signature of a call."""
        if named or not isinstance(function, types.Function | BuiltinFunctionType):
            return super().resolve_call(function, given, named)
        key = function, tuple(given)
        if key not in _signatures:
            _signatures[key] = super().resolve_call(function, given, named)
        return _signatures[key]


_signatures: dict[Any, Any] = {}


@register_pass(mutates_CFG=False, analysis_only=False)
class Types(FunctionPass):
    """Find the types of all variables and the signatures of all calls."""

    _name = "rattle_types"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> Any:
        warnings = WarningsFixer(NumbaWarning)
        inference = _Inference(state.typingctx, state.func_ir, warnings)
        called = (state.targetctx.target, inference, state.func_id, state.args)
        with state.typingctx.callstack.register(*called), warnings:
            for number, (name, kind) in enumerate(zip(state.func_ir.arg_names, state.args, strict=True)):
                inference.seed_argument(name, number, kind)
            if state.return_type is not None:
                inference.seed_return(state.return_type)
            inference.build_constraint()
            inference.propagate()
            state.typemap, state.return_type, state.calltypes = inference.unify()
        inference.__dict__.clear()  # it refers to itself: without this it would wait for the garbage collector
        return True


# ---------------------------------------------------------------- with types
@register_pass(mutates_CFG=False, analysis_only=False)
class StripPhis(typed_passes.PreLowerStripPhis):
    """Assignments in place of phi nodes."""

    _name = "rattle_strip_phis"

    def run_pass(self, state: Any) -> Any:
        state.func_ir = self._strip_phi_nodes(state.func_ir)
        return True


class Lower(lowering.Lower):
    """Numba's lowering for functions that count no references and have no debug information."""

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        """Space for a variable, without asking for its size."""
        return cgutils.alloca_once(self.builder, lltype, name=name, zfill=False)

    def storevar(self, value: Any, name: str, argidx: Any = None) -> None:
        """Store a variable, without loading what was there before."""
        self._alloca_var(name, self.typeof(name))
        if name in self._singly_assigned_vars:
            self._blk_local_varmap[name] = value
        else:
            self.builder.store(value, self.getvar(name))


@register_pass(mutates_CFG=False, analysis_only=False)
class Forget(FunctionPass):
    """Take apart what is no longer needed: variables and their scope refer to each other."""

    _name = "rattle_forget"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> Any:
        for block in state.func_ir.blocks.values():
            block.body.clear()
            block.scope.localvars._con.clear()
        state.cr.fndesc.typemap = state.cr.fndesc.calltypes = None  # as when Numba keeps a function on disk
        return True
