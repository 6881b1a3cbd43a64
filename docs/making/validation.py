"""The numbers that the tests check, measured at every build: those from the literature, then balances."""

from __future__ import annotations

import importlib.util
import itertools
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import rattle as rt
from making.runs import run
from making.text import paragraph, table
from making.tree import ROOT


def pages(folder: Path) -> dict[str, str]:
    """The list of `tests/published.py`, measured, and the balances of all examples."""
    published = module_of_tests("published")
    parts: list[str] = []
    for group, cases in itertools.groupby(published.CASES, key=lambda one: one.group):
        rows = list(cases)
        origins = [f"{one.kind}: {paragraph(one.source)}" for one in rows]
        same = len(set(origins)) == 1
        parts += [f"### {paragraph(group)}", f"{origins[0][:1].upper()}{origins[0][1:]}." if same else ""]
        cells = [_row(one, "" if same else origin) for one, origin in zip(rows, origins, strict=True)]
        parts.append(table(HEAD if same else (*HEAD, "from"), cells))
    return {"validation": "\n\n".join(part for part in parts if part) + "\n", "balances": _balances() + "\n"}


HEAD = ("what", "value", "measured here", "error", "allowed")


def module_of_tests(name: str) -> ModuleType:
    """A module that the tests read, such as the list of published numbers."""
    path = ROOT / "tests" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} cannot be read")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _row(case: Any, origin: str) -> tuple[str, ...]:
    got = case.measure()
    error = abs(got - case.expected)
    if not error <= case.tolerance:
        raise ValueError(f"{case}: {got!r} where {case.expected!r} is expected")
    what = f"{paragraph(case.what)} \\[{case.unit}\\]" if case.unit else paragraph(case.what)
    numbers = f"{case.expected:.10g}", f"{got:.10g}", power(error), power(case.tolerance)
    return (what, *numbers, origin) if origin else (what, *numbers)


def power(value: float) -> str:
    """A small number with one digit and a power of ten."""
    if value == 0.0:
        return "0"
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}·10{str(int(exponent)).translate(RAISED)}"


RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _balances() -> str:
    """Drift and energy of every example that runs in time."""
    rows = []
    for name in rt.examples():
        one = run(name)
        if one.command == "run":
            trust = one.result.trust
            share = "" if trust.energy_share is None else power(trust.energy_share)
            rows.append((f"`{name}`", power(trust.drift), power(trust.energy_balance), share))
    return table(("example", "drift [m]", "energy unaccounted for [J]", "as a share of the largest"), rows)
