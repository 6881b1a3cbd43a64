"""Objectives that are sums of squares, taken apart: f = sum r_i^2, or sqrt(f) for an objective rms(x).

From the parts r and their derivatives J a search knows the curvature 2 J^T J of f without second derivatives
(Gauss-Newton), which it would otherwise have to learn step by step.

| part of the objective | r |
|---|---|
| c*(x)**2, x a number | sqrt(c) x |
| at(x**2 + y**2, t), final | x and y at that instant |
| min(x**2 + y**2) | its root, the distance: -r would do as well |
| rms(x), rms(x)**2, mean(x**2), integral(x**2) | x at Gauss points of every interval |

Source: Nocedal, Wright, Numerical Optimization (2006), section 10.3.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from rattle.language.syntax import Apply, Name, Node, Number, walk
from rattle.results.evaluation import curve_of, evaluate
from rattle.results.reductions import Output, Reduction
from rattle.results.result import Result

READ_OFF = ("at", "final")
AVERAGED = ("mean", "integral")


@dataclass(frozen=True, eq=False)
class Square:
    """One part of a sum of squares."""

    output: Output  # the number x, or for `curve` one reduction of the curve
    factor: float  # c > 0
    form: str  # plain: r = sqrt(c) x;  root: r = sqrt(c x), x >= 0;  curve: r = sqrt(c) x at many places

    def raw(self, result: Result, parameters: Mapping[str, float], ideal: Result | None) -> np.ndarray:
        """(m,) x; nan where something is not finite."""
        if self.form != "curve":
            return np.array([evaluate(self.output, result, parameters, ideal)])
        curve = curve_of(self.output.reductions[0].inner, result, parameters, ideal)
        scale = math.sqrt(curve.span) if self.output.reductions[0].kind == "integral" else 1.0
        return scale * curve.square_parts()

    def residual(self, raw: np.ndarray) -> np.ndarray:
        """(m,) r."""
        return np.asarray(math.sqrt(self.factor) * (np.sqrt(np.maximum(raw, 0.0)) if self.form == "root" else raw))

    def slope(self, raw: np.ndarray, raw_slope: np.ndarray) -> np.ndarray:
        """(m, k) derivatives of r from those of x."""
        scale = np.full(len(raw), math.sqrt(self.factor))
        if self.form == "root":  # where a distance is zero, any of its one-sided slopes leads nowhere
            roots = np.sqrt(np.maximum(raw, 0.0))
            scale = scale * np.divide(0.5, roots, out=np.zeros_like(roots), where=roots > 0.0)
        return np.asarray(scale[:, None] * raw_slope)


def squares(objective: Output) -> list[Square] | None:
    """The parts of an objective; None if it is not a sum of squares."""
    if is_root(objective):
        return [Square(_only(objective, objective.reductions[0]), 1.0, "curve")]
    return _sum(objective, objective.outer, 1.0)


def is_root(objective: Output) -> bool:
    """True for the root of a sum of squares: an objective rms(x)."""
    reduction = _reduction(objective, objective.outer) if isinstance(objective.outer, Name) else None
    return reduction is not None and reduction.kind == "rms"


def _reduction(output: Output, name: Name) -> Reduction | None:
    """The reduction that a name of the outer tree stands for; None for a parameter."""
    return output.reductions[int(name.name[1:])] if name.name.startswith("#") else None


def _sum(output: Output, node: Node, factor: float) -> list[Square] | None:
    """Parts of factor*node; None if it is not a sum of squares."""
    if isinstance(node, Name):
        reduction = _reduction(output, node)
        return None if reduction is None else _of_reduction(output, reduction, factor)
    if not isinstance(node, Apply):
        return None
    if node.name == "+":
        sides = [_sum(output, operand, factor) for operand in node.operands]
        return None if None in sides else [square for side in sides for square in side or []]
    scaled = _scaled(node)
    if scaled is not None:
        return _sum(output, scaled[1], factor * scaled[0])
    inside = _squared(node)
    if inside is None:
        return None
    if isinstance(inside, Name) and (reduction := _reduction(output, inside)) is not None and reduction.kind == "rms":
        return [Square(_only(output, reduction), factor, "curve")]
    return [Square(_part(output, inside), factor, "plain")]


def _of_reduction(output: Output, reduction: Reduction, factor: float) -> list[Square] | None:
    """Parts of factor*reduction."""
    if reduction.kind == "min" and _never_negative(reduction.inner):
        return [Square(_only(output, reduction), factor, "root")]
    if reduction.kind not in (*READ_OFF, *AVERAGED):
        return None
    squares = []
    for part, inside in _terms(reduction.inner, 1.0) or []:
        form = "curve" if reduction.kind in AVERAGED else "plain"
        squares.append(Square(_only(output, replace(reduction, inner=inside)), factor * part, form))
    return squares or None


def _terms(node: Node, factor: float) -> list[tuple[float, Node]] | None:
    """factor*node as a sum of c*x**2: the pairs (c, x); None if it is none."""
    if not isinstance(node, Apply):
        return None
    if node.name == "+":
        sides = [_terms(operand, factor) for operand in node.operands]
        return None if None in sides else [term for side in sides for term in side or []]
    scaled = _scaled(node)
    if scaled is not None:
        return _terms(scaled[1], factor * scaled[0])
    inside = _squared(node)
    return None if inside is None else [(factor, inside)]


def _scaled(node: Apply) -> tuple[float, Node] | None:
    """(c, x) of c*x, x*c and x/c for a number c > 0."""
    if node.name not in ("*", "/"):
        return None
    left, right = node.operands
    if isinstance(right, Number) and right.value > 0.0:
        return (right.value if node.name == "*" else 1.0 / right.value), left
    if node.name == "*" and isinstance(left, Number) and left.value > 0.0:
        return left.value, right
    return None


def _squared(node: Apply) -> Node | None:
    """x of x**2."""
    if node.name == "**" and isinstance(node.operands[1], Number) and node.operands[1].value == 2.0:
        return node.operands[0]
    return None


def _never_negative(node: Node) -> bool:
    """True for sums and products of what is never negative: squares, roots, magnitudes."""
    if isinstance(node, Number):
        return node.value >= 0.0
    if not isinstance(node, Apply):
        return False
    if node.name in ("+", "*", "/"):
        return all(map(_never_negative, node.operands))
    if node.name == "**":
        return isinstance(node.operands[1], Number) and node.operands[1].value % 2.0 == 0.0
    return node.name in ("abs", "sqrt", "hypot", "exp")


# ---------------------------------------------------------------- outputs of parts
def _only(output: Output, reduction: Reduction) -> Output:
    """One reduction as an output."""
    return replace(output, reductions=(reduction,), outer=Name("#0", 0))


def _part(output: Output, node: Node) -> Output:
    """A part of the outer tree as an output, with the reductions that it uses."""
    used = sorted({int(leaf.name[1:]) for leaf in walk(node) if isinstance(leaf, Name) and leaf.name.startswith("#")})
    places = {f"#{old}": f"#{new}" for new, old in enumerate(used)}
    return replace(output, reductions=tuple(output.reductions[k] for k in used), outer=_renamed(node, places))


def _renamed(node: Node, places: Mapping[str, str]) -> Node:
    stack: list[Node] = []
    for part in walk(node):
        if isinstance(part, Apply):
            operands = tuple(stack[-len(part.operands) :])
            del stack[-len(part.operands) :]
            stack.append(Apply(part.name, operands, part.column))
        elif isinstance(part, Name):
            stack.append(Name(places.get(part.name, part.name), part.column))
        else:
            stack.append(part)
    return stack[0]
