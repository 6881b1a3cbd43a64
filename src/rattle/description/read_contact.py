"""Reading the `contact` of a joint with clearance or of a stop: a name or a table -> `Contact` with its laws.

A table may hold fields of other models, so that one word changes the model; they are checked and listed as unused.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from rattle import registry
from rattle.description.model import Choice, Contact
from rattle.description.read_fields import FieldReader
from rattle.description.read_film import film_keys, read_lubricated
from rattle.description.read_materials import material_named
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import BUSH_RADIUS, DAMPING, FILM, FORMULA, MATERIAL, ROLLING
from rattle.errors import suggest
from rattle.interfaces.contacts import ContactGeometry, ContactKind, OneSidedKind, StopKind
from rattle.interfaces.fields import Fields, LawValues
from rattle.language.materials import MATERIALS, contact_modulus
from rattle.language.recorded import sqrt
from rattle.language.units import QuantityError, dimension_of, parse_quantity

POINT = "sphere"  # the formula of a point contact
ALONG = ("friction", "tangential_restitution")  # keys of what happens along a wall
GEOMETRY = ("bush_material", "pin_material", "length", "geometry")


OF_ANGLE = {  # units of a contact whose gap is an angle
    "m": "rad", "m/s": "rad/s", "kg": "kg*m^2", "N": "N*m", "N*s/m": "N*m*s/rad",
}  # fmt: skip


class Site(NamedTuple):
    """Where a contact is: in the clearance of a joint, or at its stop."""

    title: str  # in messages
    leaf: type[ContactGeometry]  # class of its geometry
    models: list[str]  # names that `contact` may have there
    clearance: float = 0.0  # [m]
    curvature: float = 0.0  # of a disc of B that rolls there, against what it rolls on [1/m]; 0: none does

    def unit(self, unit: str) -> str:
        """Unit of a number of a contact law here: of an angle and a moment where the gap is an angle."""
        return OF_ANGLE.get(unit, unit) if self.leaf.angular else unit


def contact_models(joint: str = "") -> list[str]:
    """Every name that `contact` may have, for a kind of joint; for all joints if `joint` is ""."""
    models = registry.kinds("contact")
    if not joint:
        return [*models, *registry.kinds("normal")]
    if registry.play_of(joint) is None and registry.one_sided_of(joint) is None:
        return []
    leaf, play = registry.kinds("joint")[joint].leaf, registry.play_of(joint)
    dry = play is None or not play.leaf.holds_oil
    unfit = (
        (kind.leaf.link and not leaf.massless) or (dry and kind.leaf.oiled) or (leaf.touches and not kind.leaf.contacts)
        for kind in models.values()
    )
    left = (name for name, without in zip(models, unfit, strict=True) if not without)
    return [*left, *registry.kinds("normal")]


def stop_models() -> list[str]:
    """Every name that the `contact` of a stop may have: models with contacts."""
    kinds = registry.kinds("contact").items()
    return [*(name for name, kind in kinds if kind.leaf.contacts and not kind.leaf.oiled), *registry.kinds("normal")]


def site_of_clearance(joint: str, clearance: float) -> Site:
    """The contact of a kind of joint with a given clearance [m]."""
    play = registry.play_of(joint)
    assert play is not None, f"a {joint} joint has no clearance"
    return Site(f"a {joint} joint", play.leaf, contact_models(joint), clearance)


def site_of_one_sided(kind: registry.Kind[OneSidedKind], curvature: float = 0.0) -> Site:
    """The contact of a joint without clearance that is one-sided."""
    return Site(f"a {kind.leaf.joint} joint", kind.leaf, contact_models(kind.leaf.joint), curvature=curvature)


def site_of_stop(stop: registry.Kind[StopKind]) -> Site:
    """The contact of a kind of stop."""
    return Site("a stop", stop.leaf, stop_models())


def read_contact(reader: FieldReader, written: object, site: Site, path: Path) -> Contact | None:
    """One contact model; None after a problem."""
    values = reader.values
    table = {"model": written} if isinstance(written, str) else values.table(written, path)
    models = contact_models()
    if "model" not in table:
        values.wrong(path, "needs a model: " + ", ".join(models))
        return None
    model = table["model"]
    if fault := _without_model(model, models, site):
        values.wrong(path if isinstance(written, str) else (*path, "model"), fault)
        return None
    if not site.leaf.slides and (along := [key for key in ALONG if key in table]):
        for key in along:
            why = f"{site.title} has no friction: it pushes along the coordinate of the joint only; leave it out"
            values.wrong((*path, key), why, at_key=True)
        return None
    if "damping" in table and (why := _no_damping(table, str(model))):
        values.wrong((*path, "damping"), why, at_key=True)
        return None
    if model not in registry.kinds("contact"):
        return _compliant(reader, table, str(model), site, path)
    if registry.kinds("contact")[str(model)].leaf.oiled:
        return _oiled(reader, table, str(model), site, path)
    return _plain(reader, table, str(model), site, path)


def _without_model(model: object, models: Collection[str], site: Site) -> str:
    """Why no contact of this site has this model, in words; "" if it may."""
    if model not in models:
        hint = suggest(str(model), models)
        near = hint if "did you mean" in hint else f"; expected {', '.join(models)}"
        return f"unknown contact {quoted(model)}{near}"
    if model in site.models:
        return ""
    return f"'{model}' does not work on {site.title}; expected {', '.join(site.models)}"


def _oiled(reader: FieldReader, table: Table, model: str, site: Site, path: Path) -> Contact | None:
    """A contact with oil in the clearance, and a dry one beside it; None after a problem."""

    def dry(dry_table: Table, where: Path) -> Contact | None:
        return _compliant(reader, dry_table, str(dry_table["model"]), site, where)

    def unused(used: Collection[str]) -> tuple[str, ...]:
        return _unused(reader, table, used, site, path)

    return read_lubricated(reader, table, registry.kinds("contact")[model], site.clearance, path, dry, unused)


def _no_damping(table: Table, model: str) -> str:
    """Why a contact with this model takes no stated damping, in words; "" if it does, or has a field of that name."""
    contact, law = registry.kinds("contact").get(model), registry.kinds("normal").get(model)
    if law is not None and "damping" in law.fields:
        return ""
    if contact is not None and contact.leaf.oiled:
        return "damping belongs to the dry contact beside the oil: dry = { model, damping, ... }"
    if contact is not None and contact.leaf.contacts:
        return f"'{model}' is rigid: write restitution instead of damping, or choose a compliant model, such as hertz"
    if law is not None and "restitution" not in law.fields:
        return f"'{model}' has no restitution that a damping could stand for; leave it out"
    if law is not None and "restitution" in table:
        return "give either a damping or a restitution, not both"
    return ""


def _radius(reader: FieldReader, table: Table, site: Site, needed: str, path: Path) -> float:
    """Radius of the bush [m]; required if something depends on it."""
    clearance = site.clearance
    if not site.leaf.has_radius:
        if "bush_radius" in table:
            reader.values.wrong((*path, "bush_radius"), f"{site.leaf.wall} has no bush", at_key=True)
        return 0.0
    if "bush_radius" not in table:
        if needed:
            reader.values.wrong(
                path, f"needs bush_radius in m: {needed} depends on it (pin radius = bush_radius - clearance)"
            )
        return 0.0
    radius: float = reader.field(BUSH_RADIUS, "bush_radius", table, {}, path)
    if radius <= clearance:  # either may be nan, which was reported where it was read
        reader.values.wrong((*path, "bush_radius"), f"must be larger than the clearance of {clearance:g} m")
    return radius


def _fields_of_all() -> dict[str, registry.Field | None]:
    """Every key that a contact may have, with its field; None where it is none, or has another meaning in every law."""
    fields: dict[str, registry.Field | None] = dict.fromkeys(("friction", "bush_radius", "geometry", "rolling"))
    fields["damping"] = DAMPING
    fields |= film_keys() | {"bush_radius": None}
    for family in ("stiffness", "normal", "contact"):
        for kind in registry.kinds(family).values():
            for key, field in kind.fields.items():
                first = fields.setdefault(key, field)
                if first is not None and first.unit != field.unit:
                    fields[key] = None
    return fields


def _unused(reader: FieldReader, table: Table, used: Collection[str], site: Site, path: Path) -> tuple[str, ...]:
    """Keys of a table that only other contact models use; they are checked too.  Unknown keys are refused."""
    fields = _fields_of_all()
    reader.values.keys(table, dict.fromkeys(["model", *used, *fields]), path)
    unused = tuple(key for key in table if key not in used and key in fields)
    for key in unused:
        _check(reader, key, fields[key], table, site, path)
    return unused


def _check(reader: FieldReader, key: str, field: registry.Field | None, table: Table, site: Site, path: Path) -> None:
    """Check the value of a key that is not used."""
    if key == "friction":
        _pack(reader, "friction", _friction(reader, table[key], (*path, key)), path)
    elif key == "film":
        reader.field(FILM, key, table, {}, path)
    elif key == "bush_radius":
        _radius(reader, table, site, "", path)
    elif key == "geometry":
        reader.field(FORMULA, key, table, {}, path)
    elif field is not None and field.shape == "material":  # any formula does to check the material
        material = _elastic(reader, field, key, table, {}, path, site)
        values = {"bush_material": material, "pin_material": material, "bush_radius": 1.0, "clearance": 0.1}
        _pack(reader, "stiffness", Choice("sphere", values), path)
    elif field is not None:
        _unit_interval(reader, {key: _elastic(reader, field, key, table, {}, path, site)}, path)


def _plain(reader: FieldReader, table: Table, model: str, site: Site, path: Path) -> Contact:
    kind = registry.kinds("contact")[model]
    contacts = kind.leaf.contacts
    used = ["model", "rolling", *kind.fields, *(["bush_radius"] if contacts else [])]
    unused = _unused(reader, table, used, site, path)
    own = dict(table)
    if "friction" in kind.fields and isinstance(written := own.get("friction"), Mapping):
        law = _friction(reader, written, (*path, "friction"))
        _pack(reader, "friction", law, path)
        own["friction"] = law.values.get("mu", 0.0) if law else 0.0  # set-valued Coulomb takes the mu of any law
        left = [f"friction.{key}" for key in written if key not in ("model", "mu")]
        unused += tuple(left) if law is None or "mu" in law.values else ("friction",)
    if "stiffness" in own and "stiffness" in kind.fields:
        own["stiffness"] = _elastic(reader, kind.fields["stiffness"], "stiffness", table, {}, path, site)
    fields = reader.fields(kind, own, path)
    _unit_interval(reader, fields, path)
    unused += _of_shares(reader, kind, table, fields, path)
    if fields.get("restitution_law", 0.0) > 0.0 and fields.get("tangential_restitution", 0.0) > 0.0:
        other = kind.fields["restitution_law"].choices[int(fields["restitution_law"])]
        unfit = f'works with restitution_law = "newton" only, not with "{other}"'
        reader.values.wrong((*path, "tangential_restitution"), unfit, at_key=True)
    needed = "friction" if fields.get("friction", 0.0) > 0.0 or fields.get("tangential_restitution", 0.0) > 0.0 else ""
    radius = _radius(reader, table, site, needed, path) if contacts else 0.0
    return Contact(model, fields, radius, unused=unused, rolling=_rolling(reader, table, site, path))


def _rolling(reader: FieldReader, table: Table, site: Site, path: Path) -> float:
    """Lever arm of rolling resistance [m], 0 without."""
    if "rolling" not in table:
        return 0.0
    if site.curvature == 0.0:
        why = "only a disc that rolls on a surface resists so: give the surface a roller"
        reader.values.wrong((*path, "rolling"), why, at_key=True)
        return 0.0
    rolling: float = reader.field(ROLLING, "rolling", table, {}, path)
    return rolling


def _of_shares(
    reader: FieldReader, kind: registry.Kind[ContactKind], table: Table, fields: Fields, path: Path
) -> tuple[str, ...]:
    """Refuse what a law that shares impulses by stiffness cannot take; returns keys that the other laws do not use."""
    if not kind.leaf.shares_by_stiffness:
        return ()
    law = kind.fields["restitution_law"].choices[int(fields["restitution_law"])]
    if law != kind.leaf.shares_by_stiffness:
        return tuple(key for key in ("stiffness", "exponent") if key in table)
    if "stiffness" not in table:
        words = f'needs stiffness: "{law}" shares impulses among contacts by it'
        reader.values.wrong(path, f"{words}; if all have one exponent, only its ratios matter")
    if fields["friction"] > 0.0:
        reader.values.wrong((*path, "friction"), f'restitution_law = "{law}" knows no friction; leave one of them out')
    return ()


def _unit_interval(reader: FieldReader, fields: Fields, path: Path) -> None:
    for key in ("restitution", "tangential_restitution"):
        if key in fields and fields[key] > 1.0:
            reader.values.wrong((*path, key), f"{fields[key]:g} is outside [0, 1]")


def _compliant(reader: FieldReader, table: Table, model: str, site: Site, path: Path) -> Contact | None:
    name = _stiffness_law(reader, table, site, path)
    if not name:
        return None
    by_geometry, law, static = name != "power", registry.kinds("normal")[model], registry.kinds("stiffness")[name]
    own, damped = [key for key in static.fields if key != "bush_radius"], ""
    if "damping" in table and "damping" not in law.fields:
        law, damped = registry.damped_law(), model
    elastic_keys = ["geometry" if by_geometry else "stiffness", *law.fields, *own]
    used = ["model", "rolling", "friction", "bush_radius", *elastic_keys]
    unused = _unused(reader, table, used, site, path)
    by_radius = by_geometry and "bush_radius" in static.fields
    needed = "friction" if "friction" in table else "the stiffness" if by_radius else ""
    radius = _radius(reader, table, site, needed, path)
    elastic: dict[str, float | str | Mapping[str, float]] = {"clearance": site.clearance, "bush_radius": radius}
    for key in own:
        elastic[key] = _elastic(reader, static.fields[key], key, table, elastic, path, site)
    static_law = Choice(name, elastic)
    if by_geometry and site.curvature > 0.0 and not reader.values.problems:
        static_law = _point_contact(elastic, site.curvature)
    normal = reader.fields(law, table, path, site.unit)
    _unit_interval(reader, normal, path)
    friction = _friction(reader, table["friction"], (*path, "friction")) if "friction" in table else None
    laws = Choice(law.name, normal), static_law, friction
    rolling = _rolling(reader, table, site, path)
    contact = Contact("compliant", {}, radius, *laws, unused, word=damped, rolling=rolling)
    _pack(reader, "stiffness", contact.static, path)
    _pack(reader, "friction", friction, path)
    return contact


def _point_contact(elastic: LawValues, curvature: float) -> Choice:
    """F = K delta^1.5 of two spheres of this relative curvature [1/m], K = 4/3 E* / sqrt(curvature).

    Source: Johnson, Contact Mechanics (1985), eq. 4.23.
    """
    a, b = elastic["bush_material"], elastic["pin_material"]
    assert not isinstance(a, float), "a material is no number"
    assert not isinstance(b, float), "a material is no number"
    stiffness = 4.0 / 3.0 * contact_modulus(a, b) / sqrt(curvature)
    return Choice("power", {"stiffness": stiffness, "exponent": 1.5})


def _stiffness_law(reader: FieldReader, table: Table, site: Site, path: Path) -> str:
    """The law of the static force: "power" for a stiffness, otherwise the geometry; "" after a problem."""
    values, by_stiffness = reader.values, "stiffness" in table
    by_geometry = any(key in table for key in GEOMETRY if key != "length" or not by_stiffness)
    if by_geometry and by_stiffness:
        values.wrong((*path, "stiffness"), "give either a stiffness or materials and geometry, not both", at_key=True)
    elif by_stiffness:
        return "power"
    elif not by_geometry:
        needs = "needs a stiffness, with its exponent if that is not 1.5"
        materials = site.leaf.from_materials or site.curvature != 0.0
        other = ", or bush_material, pin_material and geometry" if materials else ": corners have no radius"
        values.wrong(path, needs + other)
    elif name := reader.field(FORMULA, "geometry", {"geometry": "sphere", **table}, {}, path):
        return _geometry_law(values, str(name), table, site, path)
    return ""


def _geometry_law(values: Values, name: str, table: Table, site: Site, path: Path) -> str:
    """The law of a geometry where it fits the place of the contact, "" after a problem."""
    if site.leaf.from_materials or (site.curvature > 0.0 and name == POINT):
        return name
    if math.isnan(site.curvature):  # its sizes are refused
        return ""
    if site.curvature > 0.0:
        point = f'a disc on a surface touches in a point: geometry = "{POINT}", or give a stiffness'
        values.wrong((*path, "geometry"), point)
        return ""
    needs = "needs stiffness and exponent: these formulas are for pins in bushes"
    values.wrong((*path, next(key for key in GEOMETRY if key in table)), f"{site.leaf.wall} {needs}", at_key=True)
    return ""


def _elastic(
    reader: FieldReader, field: registry.Field, key: str, table: Table, read: LawValues, path: Path,
    site: Site,
) -> Any:  # fmt: skip
    if field.shape == "material":
        if key not in table and field.default is registry.REQUIRED:
            reader.values.wrong(path, f"needs {key}: {field.meaning}")
            return "steel"
        material = table[key] if key in table else field.default(read)
        if isinstance(material, Mapping):
            return reader.form(MATERIAL, material, (*path, key))
        if not isinstance(material, str):
            reader.values.wrong((*path, key), f"expected the name of a material or {{ E, nu }}, got {quoted(material)}")
            return "steel"
        if material in MATERIALS or material in reader.values.materials:
            material_named(reader.values, material, (*path, key))
        own = reader.values.materials.get(material)
        return material if own is None else {"E": own.E, "nu": own.nu}
    if key == "stiffness":
        exponent = reader.values.value(table.get("exponent", 1.5), "", (*path, "exponent"), "positive")
        force, length = site.unit("N"), site.unit("m")
        unit = f"{force}/{length}^{exponent:g}" if exponent == exponent else f"{force}/{length}"
        if _is_linear(reader, table[key], f"{force}/{length}", unit):
            linear = f"{quoted(table[key])} is that of a linear spring: give exponent = 1 with it, or K in {unit}"
            reader.values.wrong((*path, key), linear)
            return math.nan
        return reader.values.value(table[key], unit, (*path, key), "positive")
    return reader.field(field, key, table, read, path)


def _is_linear(reader: FieldReader, written: object, linear: str, unit: str) -> bool:
    """True if a quantity, or a parameter, has the unit of a linear spring, which is not that asked for."""
    if not isinstance(written, str) or dimension_of(linear) == dimension_of(unit):
        return False
    with suppress(QuantityError):
        quantity = parse_quantity(written)
        dimension = reader.values.dimensions.get(written) if quantity is None else quantity[1]
        return dimension == dimension_of(linear)
    return False


def _friction(reader: FieldReader, written: object, path: Path) -> Choice | None:
    laws = registry.kinds("friction")
    if isinstance(written, Mapping) and written.get("model") == "coulomb":  # the nearest law of a compliant contact
        reader.values.keys(written, ["model", "mu"], path)
        written = written.get("mu", 0.0)
    if isinstance(written, Mapping):
        model = written.get("model")
        if not isinstance(model, str) or model not in laws:
            reader.values.wrong((*path, "model"), f"unknown friction {quoted(model)}{suggest(str(model), laws)}")
            return None
        kind = laws[model]
        reader.values.keys(written, ["model", *kind.fields], path)
        return Choice(kind.name, reader.fields(kind, written, path))
    mu = reader.values.value(written, "", path, "not negative")
    kind = laws["coulomb-smooth"]
    return Choice(kind.name, reader.fields(kind, {"mu": mu}, path)) if mu == mu else None


def _pack(reader: FieldReader, family: str, choice: Choice | None, path: Path) -> None:
    """Let the law itself refuse values that contradict each other."""
    if choice is None or reader.values.problems:
        return
    try:
        registry.law(family, choice.kind).leaf.pack(choice.values)
    except ValueError as error:
        reader.values.wrong(path, str(error))
