"""The sections of a DXF file that a mechanism is in: units, blocks, and what is drawn."""

from __future__ import annotations

from decimal import Decimal
from typing import NamedTuple

from rattle.exchange.dxf.tags import Entity, entities_of
from rattle.exchange.refusal import refused

MOST_DRAWN = 20_000  # entities, those of blocks as often as they are inserted
UNITS = {  # $INSUNITS: length in m, and the name
    1: ("0.0254", "inches"), 2: ("0.3048", "feet"), 3: ("1609.344", "miles"), 4: ("0.001", "mm"), 5: ("0.01", "cm"),
    6: ("1", "m"), 7: ("1000", "km"), 8: ("2.54e-8", "microinches"), 9: ("2.54e-5", "mils"), 10: ("0.9144", "yards"),
    11: ("1e-10", "angstroms"), 12: ("1e-9", "nm"), 13: ("1e-6", "um"), 14: ("0.1", "dm"), 15: ("10", "dam"),
    16: ("100", "hm"),
}  # fmt: skip


class Block(NamedTuple):
    """A part of a drawing that may be inserted many times."""

    base: tuple[float, float]
    entities: list[Entity]


class Sections(NamedTuple):
    """A file by sections."""

    units: int  # $INSUNITS; 0: none
    blocks: dict[str, Block]  # by names in lower case
    drawn: list[Entity]

    @property
    def metres(self) -> Decimal:
        """Length of the unit of the drawing [m]: mm where it says none."""
        return Decimal(UNITS.get(self.units, UNITS[4])[0])

    @property
    def unit(self) -> str:
        """The name of the unit; "" where the drawing says none."""
        return UNITS[self.units][1] if self.units in UNITS else ""


def sections_of(text: str, name: str) -> Sections:
    """The sections of a file.  Raises ModelError."""
    units, blocks, drawn, section = 0, dict[str, Block](), list[Entity](), ""
    inside: Block | None = None
    for entity in entities_of(text, name):
        if entity.kind == "SECTION":
            section = entity.text(2).upper()
            units = _units(entity) if section == "HEADER" else units
        elif entity.kind == "ENDSEC":
            section = ""
        elif entity.kind == "EOF" and section:
            raise refused(name, f"not a whole DXF: its section {section} does not end", entity.line)
        elif section == "ENTITIES":
            drawn.append(entity)
            if len(drawn) > MOST_DRAWN:
                raise refused(
                    name, f"more than {MOST_DRAWN} entities; save the parts of the mechanism only", entity.line
                )
        elif section == "BLOCKS":
            inside = _in_block(entity, blocks, inside)
        elif section == "" and entity.kind not in ("", "EOF"):
            raise refused(name, f"not a DXF: {entity.kind} is in no section", entity.line)
    if not drawn:
        raise refused(name, "a DXF in which nothing is drawn: its section ENTITIES is empty")
    return Sections(units, blocks, drawn)


def _units(header: Entity) -> int:
    """$INSUNITS, 0 if it is not there."""
    for variable, value in zip(header.tags, header.tags[1:], strict=False):
        if variable.code == 9 and variable.value.upper() == "$INSUNITS" and value.code == 70:
            return int(header.as_number(value))
    return 0


def _in_block(entity: Entity, blocks: dict[str, Block], inside: Block | None) -> Block | None:
    """Enter what stands in the section of blocks; returns the block that is open now."""
    if entity.kind == "BLOCK":
        block = Block((entity.number(10, 0.0), entity.number(20, 0.0)), [])
        blocks[entity.text(2).lower()] = block
        return block
    if entity.kind == "ENDBLK":
        return None
    if inside is not None:
        inside.entities.append(entity)
    return inside
