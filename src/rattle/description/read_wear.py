"""Reading the `wear` of a joint with clearance: what wears how fast, and the profiles that its surfaces have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from rattle import registry
from rattle.description.model import Contact, Wear, WearLimit
from rattle.description.read_fields import FieldReader
from rattle.description.read_values import quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import DEPTHS, LAYER, SIDES, WEAR
from rattle.interfaces.joints import JointKind
from rattle.language.recorded import as_number, bare

FEWEST, MOST = 12, 20_000  # bins
SUNK = 0.01  # penetration over clearance at which the foundation is fitted to the law of the contact


def read_wear(
    reader: FieldReader, table: Table, joint: registry.Kind[JointKind], clearance: float, contact: Contact | None,
    bearing: float | None, path: Path,
) -> tuple[Wear | None, Contact | None]:  # fmt: skip
    """The wear of one joint, None if it has none or after a problem; and its contact, of which it uses the length.

    clearance [m], 0 if there is none; table: the joint as it is written; bearing: the length that the joint itself
    says [m], which counts where its contact says none.  Without clearance only its limit counts.
    """
    if "wear" not in table or ("length" in table and not clearance > 0.0):
        return None, contact
    if contact is not None:
        contact = replace(contact, unused=tuple(key for key in contact.unused if key != "length"))
    return _wear(reader, table["wear"], joint, clearance, contact, (table.get("contact"), bearing), path), contact


def read_limit(
    reader: FieldReader, table: Table, joint: registry.Kind[JointKind], wear: Wear | None, radius: float, path: Path
) -> WearLimit | None:
    """How far the pin of a joint may wear; None if it does not, or after a problem.

    wear: that of a joint with clearance.  radius: of the pin of a joint without [m], nan if it is not known.
    """
    written, loose = table.get("wear"), wear is not None
    if not isinstance(written, Mapping) or not kind_wears(joint) or not (loose or "length" in table):
        return None
    values, before = reader.values, len(reader.values.problems)
    if wear is not None:
        rates = [wear.bush, wear.pin]
    else:
        values.keys(written, WEAR.fields, path)
        rates = [_rate(reader.part(WEAR.fields[side], side, written, path)) for side in SIDES]
    read = {key: reader.part(WEAR.fields[key], key, written, path) for key in ("limit", "band")}
    if not loose and math.isnan(bare(radius)):
        values.wrong(
            path, "needs the radius of the pin: friction = { model, mu, pin_radius }, or a contact with a bush"
        )
    if read["band"] is not None and not 0.0 < bare(read["band"][0]) < 1.0 < bare(read["band"][-1]):
        values.wrong((*path, "band"), "expected a factor below 1 and one above 1, such as [0.3, 3]")
    if len(values.problems) > before:
        return None
    band = None if read["band"] is None else (read["band"][0], read["band"][1])
    return WearLimit(sum(rates), math.nan if read["limit"] is None else read["limit"], band)


def _wear(
    reader: FieldReader, written: object, joint: registry.Kind[JointKind], clearance: float, contact: Contact | None,
    written_length: tuple[object, float | None], path: Path,
) -> Wear | None:  # fmt: skip
    """The wear as it is written; written_length: the contact as it is written, and the length of the joint itself."""
    values = reader.values
    if not _may_wear(reader, joint, clearance, path):
        return None
    if contact is not None and contact.ends_by_force:
        fault = "worn profiles know damping by a restitution only: write it in the contact instead of damping"
        values.wrong(path, fault)
        return None
    before, table = len(values.problems), values.table(written, path)
    read = reader.form(WEAR, table, path)
    bush, pin = (_rate(reader.part(WEAR.fields[side], side, table, path)) for side in SIDES)
    jump = reader.part(WEAR.fields["jump"], "jump", table, path)
    layer = _require_possible(reader, table, read, path)
    if len(values.problems) > before or contact is None:
        return None
    bed, assumed = layer if layer == layer else read["foundation"], ""
    sizes = _sizes(reader, contact, written_length, (*path[:-1], "contact"))
    if sizes is None:
        return None
    radius, length = sizes
    if bed != bed and contact.static is not None:
        bed, assumed = _fitted(contact, clearance, radius, length)
    bins = int(read["bins"])
    profile = _profile(reader, table, bins, path)
    if len(values.problems) > before:
        return None
    if profile is not None:
        _remark_round(reader, contact, path)
    return Wear(
        bush, pin, bed, radius, length, bins, read["smooth"], read["cycle"], read["cycles"],
        math.nan if jump is None else jump,
        read["wall"], profile, assumed,
    )  # fmt: skip


def _may_wear(reader: FieldReader, joint: registry.Kind[JointKind], clearance: float, path: Path) -> bool:
    """True of a joint that wears; a problem is reported otherwise."""
    if not kind_wears(joint):
        fault = f"a {joint.name} joint does not wear here; only pins in bushes do: leave it out"
        reader.values.wrong(path, fault, at_key=True)
        return False
    if not clearance > 0.0:
        fault = "needs a clearance of the joint, or for its life alone the length of the bearing: length in m"
        reader.values.wrong(path, fault)
        return False
    return True


def _remark_round(reader: FieldReader, contact: Contact, path: Path) -> None:
    """Tell that a contact does not follow the profile of its bush, if so."""
    kind = registry.kinds("contact").get(contact.model)
    if kind is not None and (kind.leaf.contacts or kind.leaf.link):
        takes = f"contact '{contact.title}' takes the bush as round; a compliant one without oil knows its profile"
        reader.values.remarks.append(f"{'.'.join(map(str, path))}: {takes}")


def _require_possible(reader: FieldReader, table: Table, read: Mapping[str, float], path: Path) -> float:
    """Refuse numbers that cannot be worked with; returns K_w [Pa/m] of the layer, nan if there is none."""
    values, bins = reader.values, read["bins"]
    if bins == bins and not (FEWEST <= bins <= MOST and bins == round(bins)):
        values.wrong((*path, "bins"), f"expected a whole number from {FEWEST} to {MOST}, got {bins:g}")
    if read["smooth"] > 0.25:
        values.wrong((*path, "smooth"), f"{read['smooth']:g} is outside [0, 0.25], where smoothing would be unstable")
    layer = _layer(reader, table, path) if "layer" in table else math.nan
    if "layer" in table and "foundation" in table:
        values.wrong((*path, "layer"), "give a foundation or the layer from which it follows, not both", at_key=True)
    return layer


def _rate(read: float | Mapping[str, float] | None) -> float:
    """k [m^2/N], as a number or from Archard's coefficient and the hardness; 0 if it is not given."""
    if isinstance(read, Mapping):
        return as_number(read["coefficient"] / read["hardness"])
    return 0.0 if read is None else as_number(read)


def _layer(reader: FieldReader, table: Table, path: Path) -> float:
    """K_w [Pa/m] of a thin layer bonded to a rigid body; nan after a problem.

    Source: Johnson, Contact Mechanics (1985), section 5.8.
    """
    read = reader.part(LAYER, "layer", table, path)
    nu = read["nu"]
    if nu >= 0.5:
        reader.values.wrong((*path, "layer", "nu"), f"{nu:g} is not below 0.5: such a layer cannot be compressed")
        return math.nan
    return as_number((1.0 - nu) * read["E"] / ((1.0 + nu) * (1.0 - 2.0 * nu) * read["thickness"]))


def _sizes(
    reader: FieldReader, contact: Contact, written: tuple[object, float | None], path: Path
) -> tuple[float, float] | None:
    """Radius of the bush and length of the contact [m]; None after a problem.

    Contacts without a law, in which nothing can wear as they are, need neither.
    """
    radius, static = contact.bush_radius, contact.static
    length = static.number("length") if static is not None and "length" in static.values else None
    of_contact, bearing = written
    table = of_contact if isinstance(of_contact, Mapping) else {}
    if contact.film is not None:
        length = contact.film.law.number("length")
    elif length is None and "length" in table:
        length = reader.values.value(table["length"], "m", (*path, "length"), "positive")
    elif length is None:
        length = bearing
    if contact.normal is None:
        return radius, math.nan if length is None else float(length)
    missing = [key for key, size in (("bush_radius", radius), ("length", length)) if not size]
    for key in missing:
        reader.values.wrong(path, f"needs {key} in m: the area that wears depends on it")
    return None if missing or length is None else (radius, float(length))


def _fitted(contact: Contact, clearance: float, radius: float, length: float) -> tuple[float, str]:
    """K_w [Pa/m] with which a round pin sinks in as by the law of its contact, and that in words."""
    static = contact.static
    assert static is not None, "called for a contact with a law"
    if static.kind == "foundation":
        return float(static.number("foundation")), ""
    laws, depth = registry.kinds("stiffness"), SUNK * clearance
    law, bed = laws[static.kind], laws["foundation"].kernel
    assert law.kernel is not None, "every law of a stiffness has a kernel"
    assert bed is not None, "so has the foundation"
    force = law.kernel.python(depth, [*law.leaf.pack(static.values), 0.0], 0)
    fitted = float(force / bed.python(depth, [radius * length, clearance], 0))
    words = f"foundation of {fitted:.3g} Pa/m: the round pin sinks in by {depth:.3g} m under {force:.3g} N"
    return fitted, f"{words}, as by '{static.kind}'"


def _profile(
    reader: FieldReader, table: Table, bins: int, path: Path
) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Depths of bush and pin [m]; None if the surfaces are round, or after a problem."""
    if "profile" in table and DEPTHS not in table:
        reader.values.wrong((*path, "profile"), f"{quoted(table['profile'])}: a model without a file has no folder")
        return None
    if DEPTHS not in table:
        return None
    here, depths = (*path, DEPTHS), reader.values.table(table[DEPTHS], (*path, DEPTHS))
    reader.values.keys(depths, SIDES, here)
    sides = []
    for side in SIDES:
        numbers = depths.get(side, [0.0] * bins)
        if not isinstance(numbers, list | tuple) or len(numbers) != bins:
            count = f"{len(numbers)} numbers" if isinstance(numbers, list | tuple) else quoted(numbers)
            what = (*path, "profile") if "profile" in table else (*here, side)
            reader.values.wrong(what, f"{side}: expected a depth in m for each of the {bins} bins, got {count}")
            return None
        sides.append(
            tuple(reader.values.value(depth, "m", (*here, side, n), "not negative") for n, depth in enumerate(numbers))
        )
    return sides[0], sides[1]


def kind_wears(joint: registry.Kind[JointKind]) -> bool:
    """True of a kind of joint whose clearance wears."""
    play = registry.play_of(joint.name)
    return play is not None and play.name in registry.kinds("worn")
