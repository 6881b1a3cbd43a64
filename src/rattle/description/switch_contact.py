"""Change the contact model of a joint by one word and keep every field that still applies."""

from __future__ import annotations

from collections.abc import Mapping

from rattle import registry
from rattle.description.model import DEFAULT_CONTACT
from rattle.description.read_film import STEEL, film_keys
from rattle.description.reading import Table, section
from rattle.errors import ModelError, Problem, suggest

ELASTIC = ("stiffness", "exponent", "bush_material", "pin_material", "length", "geometry")


def recontact(written: object, model: str) -> str | dict[str, object]:
    """The value of `contact` for another model, from the value written for the present one.

    Kept if the new model has them: restitution [-] or damping [N*s/m], friction (set-valued Coulomb keeps mu [-] of a
    friction law), bush radius [m], stiffness or materials, and the fields of the same law.  A contact with oil takes a
    compliant one as its dry contact, and leaves it where the oil goes.
    """
    old: Table = written if isinstance(written, Mapping) else {"model": written}
    plain, laws = registry.kinds("contact"), registry.kinds("normal")
    if model in plain:
        if not plain[model].leaf.contacts:
            return model
        if plain[model].leaf.oiled:
            return _oiled(old, model)
    old = _without_oil(old)
    keys = ["bush_radius", "friction", "rolling", *_own_keys(old, model)]
    new: dict[str, object] = {"model": model, **{key: value for key, value in old.items() if key in keys}}
    friction = new.get("friction")
    if model in plain and isinstance(friction, Mapping):
        new["friction"] = friction.get("mu", 0.0)
    if model in laws and "damping" in old and "restitution" not in old:
        new["damping"] = old["damping"]
    if "restitution" in new and model in laws and laws[model].fields["restitution"].default == 1.0:
        del new["restitution"]  # a law without loss
    return new if len(new) > 1 else model


def _own_keys(old: Table, model: str) -> list[str]:
    """Keys of a contact that another model has too, besides those of all."""
    plain, laws = registry.kinds("contact"), registry.kinds("normal")
    if model not in plain:
        return [*_elastic(old), *(laws[model].fields if model in laws else ())]
    shares = plain[model].leaf.shares_by_stiffness
    unused = () if shares and old.get("restitution_law") == shares else ELASTIC
    return [key for key in plain[model].fields if key not in unused]


def _without_oil(old: Table) -> Table:
    """A contact, or the dry one that is left of a lubricated one."""
    kind = registry.kinds("contact").get(str(old["model"]))
    if kind is None or not kind.leaf.oiled:
        return old
    dry = {**STEEL, "length": old.get("length")} if "dry" not in old else section(old, "dry")
    return {"bush_radius": old.get("bush_radius"), **dry}


def _elastic(old: Table) -> list[str]:
    """Keys of the stiffness of a contact, those of its geometry among them."""
    geometry = registry.kinds("stiffness").get(str(old.get("geometry")))
    return [*ELASTIC, *(geometry.fields if geometry is not None else ())]


def _oiled(old: Table, model: str) -> dict[str, object]:
    """A lubricated contact, with the oil that the table has, and its compliant contact as the dry one."""
    films, laws = film_keys(), registry.kinds("normal")
    new: dict[str, object] = {"model": model, **{key: value for key, value in old.items() if key in films}}
    present = str(old["model"])
    if "dry" not in new and present in laws:
        own = ["model", "friction", "damping", *laws[present].fields]
        own += _elastic(old) if "geometry" in old or "bush_material" in old else ELASTIC[:2]
        new["dry"] = {key: value for key, value in old.items() if key in own}
    return new


def contact_of(document: Table, joint: str) -> dict[str, object]:
    """The contact of a joint in a document, as a table.  Raises ModelError if there is no such joint or contact."""
    joints = section(document, "joints")
    if joint not in joints:
        raise ModelError([Problem(("joints", str(joint)), f"is not there{suggest(str(joint), joints)}")])
    table = section(joints, joint)
    if "clearance" not in table and "bearing" not in table and "contact" not in table:
        raise ModelError([Problem(("joints", joint), "has no clearance, so no contact")])
    written = table.get("contact", DEFAULT_CONTACT)
    return {"model": written} if isinstance(written, str) else dict(section(table, "contact"))
