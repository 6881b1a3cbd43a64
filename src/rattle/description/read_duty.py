"""The table [duty]: what a machine does for which share of its time."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

from rattle.description.model import DutyCase
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import DUTY, DUTY_CASE
from rattle.errors import suggest

LIKE = "{ share = 0.7, set = { M = 30 } }"


def read_duty(values: Values, document: Table, parameters: Collection[str]) -> tuple[DutyCase, ...]:
    """The duty cases of a model, their shares as they are written; none if it does not say any."""
    if "duty" not in document:
        return ()
    table = values.table(document["duty"], ("duty",))
    values.keys(table, DUTY.fields, ("duty",))
    path: Path = ("duty", "cases")
    written = table.get("cases")
    if not isinstance(written, list | tuple) or not written:
        words = "an empty list" if written == [] else "nothing" if written is None else quoted(written)
        values.wrong(path if "cases" in table else ("duty",), f"expected cases = [{LIKE}, ...], got {words}")
        return ()
    cases = [_case(values, case, (*path, n), parameters) for n, case in enumerate(written)]
    return tuple(case for case in cases if case is not None)


def _case(values: Values, written: object, path: Path, parameters: Collection[str]) -> DutyCase | None:
    if not isinstance(written, Mapping):
        values.wrong(path, f"expected a case such as {LIKE}, got {quoted(written)}")
        return None
    values.keys(written, DUTY_CASE.fields, path)
    share = values.value(written.get("share", 1.0), "", (*path, "share"), "positive")
    changes = values.table(written.get("set", {}), (*path, "set"))
    for name in changes:
        if name not in parameters and name not in values.broken:
            hint = suggest(name, parameters)
            values.wrong((*path, "set", name), f"no parameter {quoted(name)}{hint}", at_key=True)
    name = written.get("name", "")
    if not isinstance(name, str):
        values.wrong((*path, "name"), f"{quoted(name)} is no text; write words in quotes")
    return None if math.isnan(share) else DutyCase(share, dict(changes), str(name))
