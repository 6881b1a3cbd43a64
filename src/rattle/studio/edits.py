"""Changes of a model text by knobs: comments and all that is not changed stay as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rattle.description import file as model_file
from rattle.description.changes import Change, copied, path_of, put
from rattle.description.switch_contact import contact_of, recontact
from rattle.errors import ModelError, Problem
from rattle.value_types import Json

TURNABLE = 400_000  # characters of a text in which knobs write: some seconds, kept out of the way of other pages


def changed(text: str, name: str, value: Any) -> str:
    """The text with another value of a parameter or entry, as `Mechanism.set` names them.

    Raises ModelError for a text that cannot be read, or a name that leads nowhere.
    """
    document = model_file.parse(text)
    path = path_of(name, document, value is None)
    if path[0] == "gravity" and len(path) == 2:  # written as a whole, so that it stays on its line
        written = document.get("gravity")
        old = list(written) if isinstance(written, list) and len(written) == 2 else [0, 0]
        old[int(path[1])] = value
        path, value = ("gravity",), old
    return _written(text, document, [(path, value)])


def with_method(text: str, method: str) -> str:
    """The text with this method of integration, or none if it is "".  Raises ModelError."""
    settings = model_file.parse(text).get("simulate")
    if method or (isinstance(settings, Mapping) and "method" in settings):
        return changed(text, "simulate.method", method or None)
    return text


def with_contact(text: str, joint: str, model: str) -> str:
    """The text with another contact model of a joint; what the new one uses of the old is kept.

    Raises ModelError.
    """
    document = model_file.parse(text)
    value = recontact(contact_of(document, joint), model)
    return _written(text, document, [(("joints", joint, "contact"), value)])


def _written(text: str, document: dict[str, Json], changes: Sequence[Change]) -> str:
    renewed = copied(document)
    for path, value in changes:
        put(renewed, path, value)
    if model_file.is_json(text):
        return model_file.dump_json(renewed, text)
    return model_file.dump(renewed, text, changes)


def as_python(text: str, name: str, original: str | None) -> str:
    """Python code that makes this mechanism: from its file and what was changed since, or from the text itself.

    name: of the file, "" if there is none.  original: what the file holds, None if that is not known.
    """
    head = "import rattle as rt\n\n"
    tail = "r = m.simulate(horizon=True)\nprint(r.trust)\n"
    if name and original is not None:
        try:
            values = _difference(model_file.parse(original), model_file.parse(text))
        except ModelError:
            values = None
        if values is not None:
            lines = "".join(f"    {key!r}: {value!r},\n" for key, value in values.items())
            change = f"m = m.set({{\n{lines}}})\n" if values else ""
            return f"{head}m = rt.load({name!r})\n{change}{tail}"
    plain = '"""' not in text and not text.endswith(('"', "\\"))  # may stand in a raw text, with its backslashes
    body = f'r"""\n{text}"""' if plain else repr(text)
    return f"{head}m = rt.loads({body})\n{tail}"


def _difference(old: object, new: object, path: tuple[str, ...] = ()) -> dict[str, Any] | None:
    """Values of entries by their paths that make one document of the other; None if more than values differ."""
    if isinstance(old, dict) and isinstance(new, dict):
        if (
            path in ((), ("parameters",), ("bodies",), ("joints",), ("drivers",), ("loads",))
            and old.keys() != new.keys()
        ):
            return None
        if old.keys() == new.keys():
            changes: dict[str, Any] = {}
            for key in old:
                if "." in key:
                    return None
                part = _difference(old[key], new[key], (*path, key))
                if part is None:
                    return None
                changes |= part
            return changes
    return {} if old == new else {".".join(path): new}


def number_or_text(text: str) -> float | str:
    """What is written for an entry: a number [SI], or a quantity such as "20 ms" or an expression as text."""
    try:
        return float(text)
    except ValueError:
        return str(text).strip()


def require_turnable(text: str) -> str:
    """The text, if it is not so long that to change one value in it takes many seconds.  Raises ModelError."""
    if len(text) > TURNABLE:
        what = f"the model has {len(text)} characters; knobs change one of up to {TURNABLE}: change it under Text"
        raise ModelError([Problem((), what)])
    return text


def require_size(text: str) -> str:
    """The text, if it is one of moderate size.  Raises ModelError."""
    if not isinstance(text, str) or len(text) > model_file.LARGEST:
        raise ModelError([Problem((), "the text is too large for a model")])
    return text
