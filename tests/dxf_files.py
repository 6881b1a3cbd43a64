"""Small DXF files written by hand, and mechanisms read from them."""

import json

import rattle as rt
from rattle.exchange.dxf.read import read_dxf
from rattle.exchange.imported import Assumptions


def dxf(entities, header=(("9", "$INSUNITS"), ("70", "4")), blocks=()):
    """A file of entities, each a list of (code, value) of which the first is its kind; blocks: name, base, entities."""
    pairs = [("0", "SECTION"), ("2", "HEADER"), *header, ("0", "ENDSEC"), ("0", "SECTION"), ("2", "BLOCKS")]
    for name, (x, y), its in blocks:
        pairs += [("0", "BLOCK"), ("2", name), ("10", x), ("20", y), *(pair for entity in its for pair in entity)]
        pairs.append(("0", "ENDBLK"))
    pairs += [("0", "ENDSEC"), ("0", "SECTION"), ("2", "ENTITIES"), *(pair for entity in entities for pair in entity)]
    return "".join(f"{code}\n{value}\n" for code, value in [*pairs, ("0", "ENDSEC"), ("0", "EOF")])


def circle(layer, x, y, r, *more):
    return [("0", "CIRCLE"), ("8", layer), ("10", x), ("20", y), ("40", r), *more]


def line(layer, x, y, u, v):
    return [("0", "LINE"), ("8", layer), ("10", x), ("20", y), ("11", u), ("21", v)]


def arc(layer, x, y, r, start, end, *more):
    return [("0", "ARC"), ("8", layer), ("10", x), ("20", y), ("40", r), ("50", start), ("51", end), *more]


def outline(layer, corners, closed=1, *more):
    """An LWPOLYLINE of (x, y) or (x, y, bulge)."""
    pairs = [("0", "LWPOLYLINE"), ("8", layer), ("90", len(corners)), ("70", closed), *more]
    for x, y, *bulge in corners:
        pairs += [("10", x), ("20", y), *(("42", b) for b in bulge)]
    return pairs


def old_outline(layer, corners, flags=1):
    """A POLYLINE with its vertices, as in R12."""
    pairs = [("0", "POLYLINE"), ("8", layer), ("66", 1), ("70", flags)]
    for x, y, *bulge in corners:
        pairs += [("0", "VERTEX"), ("8", layer), ("10", x), ("20", y), *(("42", b) for b in bulge)]
    return [*pairs, ("0", "SEQEND"), ("8", layer)]


def insert(layer, block, x, y, *more):
    return [("0", "INSERT"), ("8", layer), ("2", block), ("10", x), ("20", y), *more]


def box(layer, x, y, u, v):
    return outline(layer, [(x, y), (u, y), (u, v), (x, v)])


def imported(*entities, assumptions=None, **more):
    """What is read of a drawing."""
    return read_dxf(dxf(entities, **more), "sketch.dxf", assumptions or Assumptions())


def mechanism(*entities, **more):
    """The mechanism of a drawing."""
    return rt.loads(json.dumps(imported(*entities, **more).document))
