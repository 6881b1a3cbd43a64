"""A model as it was written: read, changed and written again."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from rattle import registry
from rattle.description import file as model_file
from rattle.description.builder import Building
from rattle.description.changes import ENTRIES, Change, copied, path_of, put, through_points
from rattle.description.model import Model, Parameter
from rattle.description.read_play import hidden_names
from rattle.description.read_tables import with_files
from rattle.description.reading import Table
from rattle.description.wear_profile import with_profiles, written
from rattle.errors import ModelError, Problem, WrongType, suggest
from rattle.language.expression import names, parse
from rattle.language.units import parse_quantity, unit_of_quantity


class WrittenModel(Building):
    """The tables of a model file, with the text they came from; `model` is what they say, checked."""

    @classmethod
    def from_text(cls, text: str, file: str = "") -> Self:
        """Read model text (TOML or JSON); file: the name of its file, in whose folder tables are. Raises ModelError."""
        mechanism = cls()
        mechanism._document = model_file.parse(text, file)
        mechanism._text = text
        mechanism._file = file
        try:
            folder = Path(file).parent if file else None
            mechanism._document = with_profiles(with_files(mechanism._document, folder, file), folder, file)
        except ModelError as error:
            raise model_file.point_out(error, text) from None
        _ = mechanism.model
        return mechanism

    @cached_property
    def model(self) -> Model:
        """The checked model, all values in SI units. Raises ModelError."""
        from rattle.description.reader import read

        try:
            model = read(self._document, self._file)
        except ModelError as error:
            raise (model_file.point_out(error, self._text) if self._text else error) from None
        if not self._near:
            return model
        initial = replace(model.initial, near=self._near, near_shut=self._near_shut)
        return replace(model, initial=initial.with_places(self._held))

    @property
    def name(self) -> str:
        """Title of the model."""
        return self.model.name

    @property
    def parameters(self) -> dict[str, float]:
        """Values of all parameters by name [SI]."""
        return {name: parameter.value for name, parameter in self.model.parameters.items()}

    def parameters_where(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values of all parameters [SI] where some have these instead: what is written as an expression follows them.

        As in `set(values).parameters`, but limits are not checked, nor whether the model could be built.
        """
        from rattle.description.read_parameters import values_where

        return values_where(self._document, values)

    def parameters_with(self, changes: Mapping[str, Table], place: str) -> dict[str, Parameter]:
        """All parameters where some have these entries of the model file (tol, dist) instead, read as there.

        Raises ModelError with all that is wrong in the changes, at `place`.
        """
        from rattle.description.read_parameters import parameters_with

        for name in changes:
            self._parameter(name)
        return parameters_with(self._document, changes, place)

    def _parameter(self, name: str) -> Any:
        """A parameter as it is written.  Raises ModelError for an unknown name."""
        written = self._document.get("parameters", {})
        if name not in written and name in hidden_names(self._document):
            return {}
        if name not in written:
            raise ModelError([Problem(("parameters", name), f"no such parameter{suggest(name, written)}")])
        return written[name]

    def following(self, names: Iterable[str]) -> set[str]:
        """Parameters that change with these, which are among them."""
        values = self.parameters_where(dict.fromkeys(names, math.nan))
        return {name for name in self.parameters if not math.isfinite(values.get(name, math.nan))}

    def names_in_setting(self, key: str) -> set[str]:
        """Parameters with which a default of [simulate] is written: {"T"} for t_end = "2*T"."""
        text = self._document.get("simulate", {}).get(key)
        if not isinstance(text, str) or parse_quantity(text) is not None:
            return set()
        return set(names(parse(text, tables=self._document.get("tables", {}))))

    def joints_with_clearance(self, parameter: str) -> list[str]:
        """Joints whose clearance is this parameter itself, not an expression with it."""
        joints = self._document.get("joints", {})
        return [name for name, joint in joints.items() if str(joint.get("clearance", "")).strip() == parameter]

    def to_toml(self) -> str:
        """The model as TOML text; comments of the original text are kept.  Tables of files are written out."""
        document, changes, _ = self._written_out(lambda name: False)
        return model_file.dump(document, self._text, [*self._changes, *changes])

    def to_json(self) -> str:
        """The model as JSON text, without comments.  Tables of files are written out."""
        return model_file.dump_json(self._written_out(lambda name: False)[0])

    def _written_out(
        self, stays: Callable[[str], bool], beside: bool = False
    ) -> tuple[dict[str, object], list[Change], dict[str, str]]:
        """The document as it is written: of each table either the file or the numbers; and the changes to the text.

        stays: whether a file is still found under its name.  beside: profiles of wear go to files, which come last.
        """
        tables = self._document.get("tables", {})
        rewritten, changes = dict(tables), list[Change]()
        for name, table in tables.items():
            if "file" in table:
                leave = ("x", "y", "units") if stays(table["file"]) else ("file",)
                rewritten[name] = {key: value for key, value in table.items() if key not in leave}
                if "file" in leave:
                    changes.append((("tables", name), rewritten[name]))
        joints, of_wear, files = written(self._document.get("joints", {}), stays, beside)
        whole = self._document | ({"tables": rewritten} if tables else {}) | ({"joints": joints} if joints else {})
        return whole, [*changes, *of_wear], files

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model file, completely or not at all: JSON if its name ends in .json, otherwise TOML.

        A table that was read from a file stays in it if the model is saved in the same folder; otherwise its numbers
        are written into the model file.  Profiles of worn joints go to files beside it, `<joint>.wear.csv`.
        Raises InputError for a name that ends in neither .toml nor .json, OSError that says why it cannot be written.
        """
        json = model_file.wants_json(path)
        here = bool(self._file) and Path(self._file).resolve().parent == Path(path).resolve().parent
        document, changes, files = self._written_out(lambda name: here, beside=True)
        text = None if json else model_file.dump(document, self._text, [*self._changes, *changes])
        for name, profile in files.items():
            model_file.save(Path(path).with_name(name), profile)
        model_file.save(path, model_file.dump_json(document) if text is None else text)

    def set(self, values: Mapping[str, Any] | None = None, /, **parameters: Any) -> Self:
        """A new mechanism with some values changed; numbers are in SI units, texts may have units.

        Names are parameters, or paths as in the model file: `m.set(r3="2 mm")`, `m.set({"gravity": [0, -9.81]})`,
        `m.set({"joints.O3.contact.restitution": 0.5})`, `m.set({"loads.M": {"type": "torque", ...}})`; a load takes
        instants and values as in `load`.  None removes an entry, see `remove`.
        Raises ModelError for an unknown name or a bad value.
        """
        asked = {**(values or {}), **parameters}
        changed = self._changed(asked)
        try:
            _ = changed.model
        except ModelError as error:
            for problem in error.problems:  # the line in the old text would mislead if its value was changed
                if any(problem.path[: len(path)] == path for path, _ in changed._changes):
                    problem.line, problem.caret = None, ""
            gone = [path for path, value in changed._changes[len(self._changes) :] if value is None]
            only = all(value is None for value in asked.values()) and all(len(path) == 2 for path in gone)
            needs = changed._what_needs(gone, error) if only else []
            raise ModelError([*needs, *error.problems], error.file) from None
        return changed

    def _changed(self, asked: Table, shared: bool = False) -> Self:
        """As `set`, but what is written is not read yet.

        shared: whether it shares all tables but [parameters] with this one, for a mechanism that nobody else changes.
        """
        changed = type(self)()
        own = {"parameters": copied(self._document.get("parameters", {}))} if shared else copied(self._document)
        changed._document, changed._text, changed._file = self._document | own, self._text, self._file
        changed._changes, changed._near, changed._near_shut = list(self._changes), self._near, self._near_shut
        changed._held = self._held
        for name, value in asked.items():
            if not isinstance(name, str):
                raise WrongType(f"expected the name of a parameter or entry, as in {{'r3': '2 mm'}}; got {name!r:.60}")
            path = path_of(name, changed._document, value is None)
            if path[0] == "tables" and value is not None:
                path, value = changed._table_with(path, value)
            if path[0] == "loads":
                value = changed._load_with(path, value)
            changed._put(path, value)
            starts = changed._document.get("initial", {})
            if value is None and path[0] in ("bodies", "joints") and len(path) == 2 and path[1] in starts:
                changed._put(("initial", path[1]), None)
        folder, read = Path(changed._file).parent if changed._file else None, self._document.get("tables", {})
        changed._document = with_files(changed._document, folder, changed._file, read)
        changed._document = with_profiles(changed._document, folder, changed._file, self._document.get("joints", {}))
        return changed

    def remove(self, *names: str) -> Self:
        """A new mechanism without these entries: `m.remove("loads.M")`, or `m.remove("M")` if one entry has the name.

        The start of a removed body or joint goes along, all else that needs what is removed has to be named too:
        `m.remove("joints.O3", "drivers.motor")`.  The same as `set` with None.  Raises ModelError.
        """
        return self.set(dict.fromkeys(names))

    def _put(self, path: tuple[str, ...], value: object) -> None:
        put(self._document, path, value)
        self._changes.append((path, value))

    def _load_with(self, path: tuple[str, ...], value: object) -> object:
        """The new value of a load, or of a field of it; instants and values at them have become tables."""
        if len(path) == 2 and isinstance(value, Mapping):
            return {key: self._load_with((*path, key), part) for key, part in value.items()}
        if len(path) != 3:
            return value
        value, tables = through_points("_".join(path[1:]), value)
        for name, entry in tables.items():
            self._put(("tables", name), entry)
        return value

    def _what_needs(self, gone: Sequence[tuple[str, ...]], error: ModelError) -> list[Problem]:
        """The problem that entries were removed which others need, with all of these; none if it is not that."""
        from rattle.description.reader import read

        document, also = copied(self._document), list[tuple[str | int, str | int]]()
        while error.problems:
            entries = {(*problem.path[:2], "", "")[:2]: None for problem in error.problems}
            if any(
                table not in (*ENTRIES, "initial") or name not in document.get(table, {}) for table, name in entries
            ):
                return []
            for table, name in entries:
                also.append((table, name))
                del document[table][name]
            try:
                read(document, self._file)
                break
            except ModelError as next_one:
                error = next_one
        parts = {name for table, name in also if table in ("bodies", "joints")}  # their starts go along
        named = [f"{table}.{name}" for table, name in also if table != "initial" or name not in parts]
        those = f"{', '.join(named[:-1])} and {named[-1]}: remove them" if named[1:] else f"{named[0]}: remove that"
        return [Problem(gone[0], f"still needed by {those} too, or change what needs it in the same call")]

    def _table_with(self, path: tuple[str, ...], value: object) -> tuple[tuple[str, ...], object]:
        """Path and new value that change a table as a whole, if its numbers come from a file or shall do so."""
        entry = self._document.get("tables", {}).get(path[1] if len(path) > 1 else "")
        if len(path) < 3 or not isinstance(entry, Mapping) or ("file" not in entry and path[2] != "file"):
            return path, value
        whole = copied(dict(entry))
        put(whole, path[2:], value)
        for key in ("x", "y", "units") if path[2] == "file" else ("file",):
            whole.pop(key, None)
        return path[:2], whole

    def written_unit(self, name: str) -> tuple[float, str]:
        """Unit of a parameter as the model file writes its value: its size in SI units, and its name; 1 and "" if none.

        Raises ModelError for an unknown name.
        """
        value = self._parameter(name)
        text = value.get("value") if isinstance(value, Mapping) else value
        return unit_of_quantity(text) if isinstance(text, str) else (1.0, "")

    def ideal(self) -> Self:
        """The same mechanism with all clearances set to zero; lengths of the bodies are unchanged, surfaces stay."""
        from rattle.description.switch_contact import recontact

        joints = self._document.get("joints", {})
        loose = [name for name, table in joints.items() if _has_contact(table) and not _touches(table)]
        return self.set({f"joints.{name}.contact": recontact(joints[name].get("contact"), "ideal") for name in loose})

    def with_contact(self, model: str, joint: str | None = None) -> Self:
        """The same mechanism with another contact model in every joint with clearance or one-sided, or in one joint.

        model: a name of `rattle kinds`, such as "massless-link", "impact" or "exact".  Values of the old model that
        the new one uses are kept: restitution, friction, bush radius, stiffness or materials.
        Raises ModelError if a value is missing (a compliant model needs a stiffness) or no joint has a clearance.
        """
        from rattle.description.switch_contact import recontact

        joints = self._document.get("joints", {})
        loose = [name for name, table in joints.items() if _has_contact(table) and joint in (None, name)]
        if joint is not None and not loose:
            what = "has no clearance" if joint in joints else f"is not there{suggest(joint, joints)}"
            raise ModelError([Problem(("joints", joint), what)])
        if not loose:
            raise ModelError([Problem(("joints",), f"no joint has a clearance, so contact '{model}' applies to none")])
        return self.set({f"joints.{name}.contact": recontact(joints[name].get("contact"), model) for name in loose})

    def contact_of(self, joint: str) -> dict[str, object]:
        """The contact of a joint as it is written in the model, as a table. Raises ModelError if it has none."""
        from rattle.description.switch_contact import contact_of

        return contact_of(self._document, joint)


def _touches(table: Mapping[str, object]) -> bool:
    """True of a joint whose bodies touch outside of any joint: nothing is left of it without its contact."""
    kind = registry.kinds("joint").get(str(table.get("type")))
    return kind is not None and (kind.leaf.touches or kind.leaf.lifting is not None)


def _has_contact(joint: Table) -> bool:
    """True of a joint as it is written with clearance, or one-sided."""
    return "clearance" in joint or "bearing" in joint or "contact" in joint
