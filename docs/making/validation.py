"""What the tests hold the program to, measured anew at every build: numbers from elsewhere, then balances."""

from __future__ import annotations

import importlib.util
import itertools
import sys
from pathlib import Path
from types import ModuleType

import rattle as rt
from making.runs import run
from making.text import paragraph, table
from making.tree import ROOT


def pages(folder: Path) -> dict[str, str]:
    """The list of `tests/published.py`, measured, and the balances of all examples."""
    published = _published()
    parts: list[str] = []
    for group, cases in itertools.groupby(published.CASES, key=lambda one: one.group):
        parts += [f"### {paragraph(group)}", table(HEAD, [_row(one) for one in cases])]
    return {"validation": "\n\n".join(parts) + "\n", "balances": _balances() + "\n"}


HEAD = ("what", "from", "value", "measured here", "error", "allowed")


def _published() -> ModuleType:
    """The list that the tests read, as a module."""
    path = ROOT / "tests" / "published.py"
    spec = importlib.util.spec_from_file_location("published", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} cannot be read")
    module = sys.modules["published"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _row(case: object) -> tuple[str, ...]:
    got = case.measure()
    error = abs(got - case.expected)
    if not error <= case.tolerance:
        raise ValueError(f"{case}: {got!r} where {case.expected!r} is expected")
    what = f"{paragraph(case.what)} [{case.unit}]" if case.unit else paragraph(case.what)
    said = f"{case.kind}: {paragraph(case.source)}"
    return what, said, f"{case.expected:.10g}", f"{got:.10g}", f"{error:.1g}", f"{case.tolerance:.1g}"


def _balances() -> str:
    """Drift and energy of every example that runs in time."""
    rows = []
    for name in rt.examples():
        one = run(name)
        if one.command == "run":
            trust = one.result.trust
            share = "" if trust.energy_share is None else f"{trust.energy_share:.0e}"
            rows.append((f"`{name}`", f"{trust.drift:.0e}", f"{trust.energy_balance:.0e}", share))
    return table(("example", "drift [m]", "energy unaccounted for [J]", "as a share of the largest"), rows)
