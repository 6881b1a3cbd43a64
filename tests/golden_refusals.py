"""Wrong model texts in all tables of a model, and every word that is answered; also the schema and `rattle kinds`.

`python tests/golden_refusals.py` writes the answers anew: `tests/data/refusals.txt`, `schema.txt` and
`kinds.txt`.  Texts are sound documents, shipped examples and those below, each with one change; of every table (joints,
contacts ... of one kind count as one table) every key is left out and misspelt once, and has some wrong values.
"""

from __future__ import annotations

import copy
import functools
import json
import random
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from click.testing import CliRunner

import rattle as rt
from mutants import _value
from rattle import registry
from rattle.cli.files import kinds
from rattle.description.file import dump, parse
from rattle.description.reference import topics
from rattle.description.schema import schema

DATA = Path(__file__).parent / "data"
REFUSALS, SCHEMA, KINDS = (DATA / name for name in ("refusals.txt", "schema.txt", "kinds.txt"))
NAMED = ("parameters", "signals", "states", "tables", "bodies", "joints", "drivers", "loads", "initial")
SIGNS = ("type", "model", "film", "geometry", "coordinate", "polygon", "bar", "file", "offset")  # of a kind of table
WRONG: dict[str, Any] = {
    "list": [1, 2, 3], "truth": True, "word": "nosuch", "table": {"nosuch": 1}, "unit": "3 A*kg", "negative": -1,
    "zero": 0, "broken": "2*(1", "time": "sin(t)", "huge": "1e400", "pair": ["nosuch.P", -2], "tiny": 1e-300,
}  # fmt: skip
KEPT = 2  # wrong values of one key
DRAWN = 120  # shipped examples of which any one value is another

FRAME = """
format = 1
[parameters]
r = "5 mm"
[ground.points]
O = [0, 0]
P = [0.1, 0]
[bodies.a]
points = { O = [0, 0], P = [0.1, 0] }
mass = 1
inertia = 0.01
[bodies.b]
points = { O = [0, 0], P = [0.1, 0] }
mass = 1
inertia = 0.01
[joints.hinge]
type = "revolute"
connect = ["ground.O", "a.O"]
"""
JOINTS = {
    "belt": "radii = [0.02, 0.03]\nstiffness = 1000\ndamping = 1\npretension = 10\nfriction = 0.3\ncrossed = true",
    "cam": 'radius = "0.1 + 0*a"\nroller = "1 mm"\ncontact = { model = "impact", restitution = 0.5 }',
    "clutch": 'model = "compliant"\nsense = -1\ndamping = 1\nstiffness = 10',
    "fixed": 'angle = "10 deg"',
    "flat-follower": 'axis = 0.1\nsupport = "0.1 + 0*x"',
    "gear": 'radii = ["50 mm", "50 mm"]\nbacklash = "0.1 mm"\npressure_angle = "20 deg"\ncontact = "impact"',
    "locking-disc": 'radius = 0.03\narcs = 4\naxle_distance = 0.1\nrim = 0.09\nplay = 1e-4\ncontact = "impact"',
    "prismatic": 'axis = 0.1\nangle = 0\nclearance = "1 mm"\nblock = { length = "20 mm", height = "10 mm" }\n'
    'contact = "impact"',
    "rack": 'axis = 0.1\nradius = "10 mm"\nfriction = { mu = 0.1, module = "1 mm", pressure_angle = "20 deg" }',
    "rod": 'length = "0.1 m"\nfriction = { mu = 0.1, mu_static = 0.2, pin_radius = "5 mm" }',
    "slot": 'axis = 0.1\nlength = "50 mm"\nopen = "both"\nclearance = "0.1 mm"\ncontact = "impact"',
    "surface": 'axis = 0.1\nlength = "1 m"\ncorners = ["O", "P"]\n'
    'contact = { model = "impact", restitution = 0.5, friction = 0.3 }',
    "wheel": 'axis = 0.1\nradius = "50 mm"\nfriction = { mu = 0.1, mu_static = 0.2 }',
    "revolute": 'stop = { min = "-10 deg", max = 1, contact = { model = "impact", restitution = 0.5 } }',
}
LOADS = {
    "actuator": 'connect = ["ground.P", "b.P"]\nforce = "10*sin(t)"',
    "bushing": 'connect = ["ground.P", "b.P"]\nstiffness = [1, 2, 3]\ndamping = [1, 2, "3 N*m*s/rad"]'
    "\noffset = [0, 0, 1]",
    "force": 'at = "a.P"\nforce = [1, "sin(t)"]\nframe = "body"',
    "motor": 'connect = ["ground", "a"]\ntorque = "1 - 0.1*speed"',
    "spring": 'connect = ["ground.P", "b.P"]\nstiffness = 100\nfree_length = "5 mm"\ndamping = 1\ntension_only = true',
    "torque": 'body = "a"\ntorque = "1 N*m"',
    "torsion-spring": 'connect = ["ground", "a"]\nstiffness = 10\nfree_angle = "5 deg"\ndamping = 1',
}
DRIVERS = {
    "angle": 'joint = "hinge"\nangle = "10*t"',
    "position": 'joint = "slide"\nposition = "0.1*t"',
    "x": 'body = "a.P"\ncoordinate = "x"\nposition = "0.1*t"',
    "y": 'body = "a"\ncoordinate = "y"\nposition = "0.1*t"',
    "angle of a body": 'body = "a"\ncoordinate = "angle"\nangle = "0.1*t"',
}
SLIDE = '[joints.slide]\ntype = "prismatic"\nconnect = ["ground.P", "b.P"]\n'
OIL = 'viscosity = "20 mPa*s", length = "20 mm", bush_radius = "0.1 m", roughness = ["1 um", "2 um"]'
DRY = 'dry = { model = "exact", stiffness = 1e8, exponent = 1.5, restitution = 0.5, friction = 0.1 }'
WEAR = (
    'wear = { bush = "1e-15 m^2/N", pin = { coefficient = 1e-4, hardness = "2 GPa" }, bins = 12, smooth = 0.1,'
    ' cycle = "1 s", cycles = 1000, wall = "1 mm", jump = 10, %s }'
)
IMPACT = 'contact = { model = "impact", restitution = 0.5, bush_radius = "10 mm", friction = 0.1 }'
OTHERS = {
    "plate": '[bodies.p]\npolygon = [[0, 0], [1, 0], [0, 1]]\nholes = [[[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]]\n'
    'thickness = "5 mm"\ndensity = "7850 kg/m^3"\npoints = { A = [0, 0] }',
    "heavy plate": "[bodies.p]\npolygon = [[0, 0], [1, 0], [0, 1]]\nmass = 1",
    "bar": '[bodies.s]\nbar = ["A", "B"]\nlength = "0.1 m"\nmass = 1\ninertia = 0.1\npoints = { C = [0.01, 0] }',
    "body": '[bodies.s]\nmass = "1 kg"\ninertia = 0.1\ncenter = [0.1, 0]\npoints = { C = ["1 mm", 0] }',
    "states": '[states]\ni = { rate = "(1 - i)/t_c", start = 0.5 }\n[parameters.t_c]\nvalue = "2 s"\nmin = "1 s"\n'
    'max = "3 s"\ntol = "0.1 s"\ndist = "normal"\nlabel = "time"\ndescription = "of the coil"',
    "values": '[parameters.w]\nvalue = "2 s"\ndist = { values = ["1 s", "2 s"], weights = [1, 2] }\n'
    '[tolerances]\ngroups = [["w", "r"]]',
    "table": '[tables.f]\nx = [0, 1, 2, 3]\ny = [0, "1 mm", 2, 0]\nunits = ["deg", "mm"]\n'
    'kind = "spline"\nperiod = "3 deg"',
    "table of a file": '[tables.f]\nfile = "lift.csv"\nkind = "linear"',
    "signals": '[signals]\nspeed = "hypot(a.vx, a.vy)"\nhalf = 0.5',
    "start": '[initial]\na = { x = 0, y = "1 mm", angle = "5 deg", vx = 0, vy = 0, omega = 1 }\n'
    '[joints.loose]\ntype = "revolute"\nconnect = ["a.P", "b.O"]\nclearance = "1 mm"\n[initial.loose]\noffset = [0, 0]',
    "simulate": '[simulate]\nt_end = "1 s"\nrtol = 1e-6\natol = 1e-9\nstep = "1 ms"\noutput = "1 ms"\nmethod = "rk4"',
    "gravity": '',
}  # fmt: skip
HAND = {  # of what can be contradictory: a base, and what is written instead of what there
    "plate with mass and thickness": ("plate", "thickness =", "mass = 1\nthickness ="),
    "plate with inertia": ("plate", "thickness =", "inertia = 1\ncenter = [0, 0]\nthickness ="),
    "plate without density": ("plate", 'density = "7850 kg/m^3"\n', ""),
    "plate with two corners": ("plate", "[[0, 0], [1, 0], [0, 1]]", "[[0, 0], [1, 0]]"),
    "plate with crossing sides": ("plate", "[[0, 0], [1, 0], [0, 1]]", "[[0, 0], [1, 1], [1, 0], [0, 1]]"),
    "hole outside": ("plate", "[0.1, 0.2]]]", "[0.1, 2]]]"),
    "hole without brackets": ("plate", "[[[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]]", "[0.1, 0.2]"),
    "plate of nothing": ("heavy plate", "1]]\nmass = 1", "1]]"),
    "ends of one name": ("bar", '["A", "B"]', '["A", "A"]'),
    "end named like a point": ("bar", '["A", "B"]', '["A", "C"]'),
    "ends that are no names": ("bar", '["A", "B"]', '["A", "B.x"]'),
    "bar without length": ("bar", 'length = "0.1 m"\n', ""),
    "body without inertia": ("body", "inertia = 0.1\n", ""),
    "inertia out of range": ("bar", 'length = "0.1 m"\nmass = 1\ninertia = 0.1', "length = 1e40\nmass = 1e40"),
    "state and parameter": ("states", "[states]\ni =", "[states]\nr ="),
    "rate of another dimension": ("states", "start = 0.5", 'start = "1 A"'),
    "state that is a number": ("states", "[states]", "[states]\nk = 1"),
    "label too long": ("states", 'label = "time"', f'label = "{61 * "x"}"'),
    "value beyond its limits": ("states", 'value = "2 s"', 'value = "4 s"'),
    "bare value beyond its limits": ("states", 'value = "2 s"', "value = 4"),
    "value unlike its limits": ("states", 'value = "2 s"', 'value = "2 m"'),
    "value below": ("states", 'max = "3 s"\n', 'max = "nosuch s"\n'),
    "unknown distribution": ("states", '"normal"', '"gauss"'),
    "weights of another number": ("values", "[1, 2]", "[1]"),
    "weights of zero": ("values", "[1, 2]", "[0, 0]"),
    "no values": ("values", '["1 s", "2 s"]', "[]"),
    "group of one": ("values", '["w", "r"]', '["w"]'),
    "twice in a group": ("values", '["w", "r"]', '["w", "w"]'),
    "in two groups": ("values", '["w", "r"]', '["w", "r"], ["r", "w"]'),
    "group of numbers": ("values", '["w", "r"]', '["w", 2]'),
    "x does not increase": ("table", "[0, 1, 2, 3]", "[0, 2, 1, 3]"),
    "x and y of other lengths": ("table", "[0, 1, 2, 3]", "[0, 1]"),
    "period too short": ("table", '"3 deg"', '"1 deg"'),
    "period of another dimension": ("table", '"3 deg"', '"1 m"'),
    "periodic without closing": ("table", '"1 mm", 2, 0]', '"1 mm", 2, 1]'),
    "spline of two": ("table", 'x = [0, 1, 2, 3]\ny = [0, "1 mm", 2, 0]', 'x = [0, 3]\ny = [0, 0]'),
    "one point": ("table", 'x = [0, 1, 2, 3]\ny = [0, "1 mm", 2, 0]', 'x = [0]\ny = [0]'),
    "y of several dimensions": ("table", '"1 mm", 2, 0]', '"1 mm", "1 s", 0]'),
    "table named like a function": ("table", "tables.f", "tables.sin"),
    "table named like a parameter": ("table", "tables.f", "tables.r"),
    "units that are none": ("table", '["deg", "mm"]', '["deg", "mmm"]'),
    "units of one": ("table", '["deg", "mm"]', '["deg"]'),
    "table without points": ("table", "x = [0, 1, 2, 3]\n", ""),
    "file and points": ("table of a file", "kind", "x = [1, 2]\nkind"),
    "signals in a ring": ("signals", "0.5", '"2*speed + half"'),
    "signal and parameter": ("signals", "half", "r"),
    "signal and body": ("signals", "half", "a"),
    "signal that is true": ("signals", "0.5", "true"),
    "offset of a body": ("start", "x = 0", "offset = [0, 0]"),
    "start of nobody": ("start", "[initial]\na =", "[initial]\nc ="),
    "offset without clearance": ("start", "initial.loose", "initial.hinge"),
    "unknown method": ("simulate", '"rk4"', '"rk5"'),
    "gravity of one": ("gravity", "format = 1", "format = 1\ngravity = [1]"),
    "gravity of metres": ("gravity", "format = 1", 'format = 1\ngravity = [0, "9.81 m"]'),
    "another format": ("gravity", "format = 1", "format = 2"),
    "format that is true": ("gravity", "format = 1", "format = true"),
    "title of numbers": ("gravity", "format = 1", "format = 1\nname = 3"),
    "unknown table": ("gravity", "[parameters]", "[parameter]"),
    "ground of points": ("gravity", "[ground.points]", "[ground]"),
    "points that are no table": ("gravity", "[ground.points]\nO = [0, 0]\nP = [0.1, 0]", "[ground]\npoints = [1]"),
    "bodies that are no table": ("gravity", "format = 1", "format = 1\nloads = 3"),
    "body that is none": ("gravity", "[bodies.a]", "[bodies]\nc = 3\n[bodies.a]"),
    "names that are none": ("gravity", "bodies.a]", 'bodies."a b"]'),
    "reserved word": ("gravity", "bodies.b]", "bodies.energy]"),
    "joint named like a body": ("gravity", "joints.hinge", "joints.a"),
    "parameter by itself": ("gravity", '"5 mm"', '"2*r"'),
    "parameter without value": ("gravity", '"5 mm"', "{ min = 1 }"),
    "joint on one body": ("gravity", '"ground.O"', '"a.P"'),
    "no connect": ("gravity", 'connect = ["ground.O", "a.O"]\n', ""),
    "three ends": ("gravity", '["ground.O", "a.O"]', '["ground.O", "a.O", "b.O"]'),
    "foundation and layer": ("worn", "%s", 'foundation = 1e12, layer = { E = "1 GPa", thickness = "1 mm" }'),
    "layer that cannot be compressed": ("worn", "%s", 'layer = { E = "1 GPa", thickness = "1 mm", nu = 0.5 }'),
    "depths of another number": ("worn", "%s", "foundation = 1e12, depths = { pin = [0, 0] }"),
    "depths and profile": ("worn", "%s", 'depths = { pin = [0, 0] }, profile = "pin.wear.csv"'),
    "profile without a folder": ("worn", "%s", 'profile = "pin.wear.csv"'),
    "too few bins": ("worn", "bins = 12", "bins = 11.5"),
    "smoothing too much": ("worn", "smooth = 0.1", "smooth = 0.3"),
    "wear without clearance": ("worn", 'clearance = "1 mm"\n', ""),
    "wear of a slider": ("worn", '"revolute"\nconnect = ["a.P"', '"prismatic"\nconnect = ["a.P"'),
    "oil thinner than its boundary": ("oil finite", '"1 um", "2 um"', '"1 mm", "2 mm"'),
    "oil of three roughnesses": ("oil finite", '"1 um", "2 um"', '"1 um", "2 um", "3 um"'),
    "dry contact without model": ("oil finite", 'model = "exact", ', ""),
    "dry contact of impacts": ("oil finite", '"exact"', '"impact"'),
    "bush of two radii": ("oil finite", 'dry = { model', 'dry = { bush_radius = "21 mm", model'),
    "oil in a slider": ("oil finite", '"revolute"\nconnect = ["a.P"', '"prismatic"\nconnect = ["a.P"'),
    "stiffness and material": ("contact exact", "stiffness = 1e8", 'stiffness = 1e8, bush_material = "steel"'),
    "neither stiffness nor material": ("contact exact", "stiffness = 1e8, exponent = 1.5, ", ""),
    "unknown geometry": ("law sphere", '"sphere"', '"cube"'),
    "restitution above one": ("contact exact", "restitution = 0.5", "restitution = 1.5"),
    "bush smaller than its clearance": ("contact exact", '"10 mm"', '"1 mm"'),
    "contact without a model": ("contact exact", 'model = "exact", ', ""),
    "friction of no law": ("friction lugre", '"lugre"', '"nosuch"'),
    "damping beside restitution": ("contact exact", "restitution = 0.5", "restitution = 0.5, damping = 10"),
    "damping of a rigid contact": ("joint revolute", "restitution = 0.5", "damping = 10"),
    "friction stated beside mu": ("joint revolute", "stop =", "friction = { torque = 2, mu = 0.1 }\nstop ="),
    "friction stated of another kind": ("joint revolute", "stop =", "friction = { force = 2 }\nstop ="),
    "friction with play": ("contact exact", "clearance =", "friction = 0.1\nclearance ="),
    "rod with a length and stops": ("joint rod", "length =", "stop = { max = 1 }\nlength ="),
    "rope with friction": ("joint rod", 'length = "0.1 m"', "stop = { max = 1 }"),
    "rope with ends that cross": ("joint rod", 'length = "0.1 m"\nfriction', 'stop = { max = 1, min = 2 }\nfriction'),
    "stop without ends": ("joint revolute", 'min = "-10 deg", max = 1, ', ""),
    "stop with ends that cross": ("joint revolute", "max = 1", 'max = "-20 deg"'),
    "stop with friction": ("joint revolute", "restitution = 0.5", "friction = 0.5"),
    "stop with a massless link": ("joint revolute", '{ model = "impact", restitution = 0.5 }', '"massless-link"'),
    "driver of a joint and a body": ("driver x", "body =", 'joint = "hinge"\nbody ='),
    "two drivers": ("driver angle", "[drivers.d]", '[drivers.e]\njoint = "hinge"\nangle = "t"\n[drivers.d]'),
    "driver of the ground": ("driver x", '"a.P"', '"ground.P"'),
    "coordinate of a joint": ("driver angle", "joint =", 'coordinate = "x"\njoint ='),
    "position of a hinge": ("driver angle", "angle =", "position ="),
    "driver that follows the motion": ("driver angle", '"10*t"', '"a.x"'),
    "moment on the same body": ("load motor", '"ground", "a"', '"a", "a"'),
    "torque on a point": ("load torque", '"a"', '"a.P"'),
}  # fmt: skip


class Wrong(NamedTuple):
    """A wrong model text."""

    title: str  # which base, and what is wrong there
    text: str


def bases() -> Iterator[tuple[str, str]]:
    """Sound model texts by title: all kinds of everything."""
    loose = f'{FRAME}[joints.loose]\ntype = "revolute"\nconnect = ["a.P", "b.O"]\nclearance = "1 mm"\n'
    for title, text in OTHERS.items():
        yield title, f"{FRAME}{text}\n"
    for name, text in JOINTS.items():
        ends = '["a", "b"]' if name == "clutch" else '["a.P", "b.P"]'
        yield f"joint {name}", f'{FRAME}[joints.j]\ntype = "{name}"\nconnect = {ends}\n{text}\n'
    for name, text in LOADS.items():
        yield f"load {name}", f'{FRAME}[loads.l]\ntype = "{name}"\n{text}\n'
    for name, text in DRIVERS.items():
        yield f"driver {name}", f"{FRAME}{SLIDE}[drivers.d]\n{text}\n"
    for name in registry.kinds("film"):
        more = "" if name == "pinkus-sternlicht" else ', cavitation = "reynolds"'
        yield f"oil {name}", f'{loose}contact = {{ model = "lubricated", film = "{name}", {OIL}{more}, {DRY} }}\n'
    for name, law in registry.kinds("normal").items():
        stiff = ", effective_mass = 1" if "effective_mass" in law.fields else ""
        law_of = f'stiffness = 1e8, exponent = {1 if stiff else 1.5}, restitution = 0.5{stiff}, bush_radius = "10 mm"'
        yield f"contact {name}", f'{loose}contact = {{ model = "{name}", {law_of} }}\n'
    for name in registry.kinds("stiffness"):
        law_of = 'bush_radius = "10 mm", length = "20 mm", restitution = 0.5'
        law_of += ", foundation = 1e12" if name == "foundation" else ', bush_material = { E = "200 GPa", nu = 0.3 }'
        if name != "power":
            yield f"law {name}", f'{loose}contact = {{ model = "exact", geometry = "{name}", {law_of} }}\n'
    for name, law in registry.kinds("friction").items():
        mu = ", ".join(f"{key} = {0.1 + 0.1 * (key in ('mu_static', 'v1'))}" for key in law.fields)
        whole = f'{{ model = "{name}", {mu} }}'
        elastic = 'model = "exact", stiffness = 1e8, restitution = 0.5, bush_radius = "10 mm"'
        yield f"friction {name}", f"{loose}contact = {{ {elastic}, friction = {whole} }}\n"
        yield f"friction {name} of a pin", f"{FRAME}friction = {whole[:-2]}, pin_radius = 0.01 }}\n"
    bed = 'model = "exact", geometry = "johnson", bush_material = "steel", length = 0.02, bush_radius = 0.01'
    yield "worn", f"{loose}contact = {{ {bed}, restitution = 0.5 }}\n{WEAR}\n"
    layer = 'layer = { E = "1 GPa", nu = 0.3, thickness = "1 mm" }, depths = { pin = [' + ", ".join(12 * "0") + "] }"
    yield "worn layer", f"{loose}contact = {{ {bed}, restitution = 0.5 }}\n{WEAR % layer}\n"
    yield "impact", f"{loose}{IMPACT}\n"
    yield "full", (DATA / "full.toml").read_text()
    for name in sorted(rt.examples()):
        yield name, rt.example(name).to_toml()


def wrong_texts() -> Iterator[Wrong]:
    """All wrong texts, and a few of the sound ones that chance makes."""
    texts = dict(bases())
    for title, (base, old, new) in HAND.items():
        if old not in texts[base]:
            raise KeyError(f"{title}: {old!r} is not in '{base}'")
        yield Wrong(f"{title} ({base})", texts[base].replace(old, new, 1))
    told: set[str] = set()
    for base, text in texts.items():
        document = parse(text.replace(", %s", ""))
        for title, changed in _changes(document, told):
            yield Wrong(f"{title} ({base})", dump(changed, None, []))
    shipped = sorted(rt.examples())
    for number in range(DRAWN):
        draw = random.Random(f"refusals {number}")
        base = draw.choice(shipped)
        text = _value(texts[base], draw)
        try:
            tomllib.loads(text)
        except tomllib.TOMLDecodeError:  # in the words of the version of Python
            continue
        yield Wrong(f"drawn {number} ({base})", text)


def _changes(document: Mapping[str, Any], told: set[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Documents with one change in tables that were not told yet, and what it is."""
    for path, place in list(_places(document, (), "")):
        if place in told:
            continue
        told.add(place)
        table = functools.reduce(lambda part, key: part[key], path[:-1], document)
        key = path[-1]
        draw = random.Random(place)
        if isinstance(key, str):
            yield f"{place} misspelt", _with(document, path, lambda part, key=key: _renamed(part, key))
            yield f"{place} left out", _with(document, path, lambda part, key=key: part.pop(key))
        for name in sorted(draw.sample(sorted(WRONG), KEPT)):
            if table[key] != WRONG[name]:
                put = WRONG[name]
                yield f"{place} {name}", _with(document, path, lambda part, key=key, put=put: _put(part, key, put))


def _renamed(part: dict[str, Any], key: str) -> None:
    part[f"{key}x"] = part.pop(key)


def _put(part: Any, key: Any, value: Any) -> None:
    part[key] = copy.deepcopy(value)


def _with(document: Mapping[str, Any], path: tuple[Any, ...], change: Any) -> dict[str, Any]:
    """A document with a change in the table or list that holds the end of a path."""
    changed = copy.deepcopy(dict(document))
    change(functools.reduce(lambda part, key: part[key], path[:-1], changed))
    return changed


def _places(part: Any, path: tuple[Any, ...], place: str) -> Iterator[tuple[tuple[Any, ...], str]]:
    """Paths of all keys of a document, and what they are whatever the names of its parts."""
    if isinstance(part, Mapping):
        signs = "|".join(_sign(part, key) for key in SIGNS if key in part)
        for key, value in part.items():
            own = len(path) == 1 and path[0] in NAMED
            name = "*" if own or path[-1:] == ("points",) else key
            here = f"{place}{f'<{signs}>' if signs and not own else ''}.{name}".removeprefix(".")
            yield (*path, key), here
            yield from _places(value, (*path, key), here)
    elif isinstance(part, list) and part:
        yield (*path, 0), f"{place}[0]"
        yield from _places(part[0], (*path, 0), f"{place}[0]")


def _sign(part: Mapping[str, Any], key: str) -> str:
    return part[key] if isinstance(part[key], str) and key not in ("bar", "file") else key


def answer(text: str) -> str:
    """What is said of a text, "" of a sound one."""
    try:
        rt.loads(text)
    except rt.InputError as error:
        return str(error)
    return ""


def refusals() -> str:
    """All wrong texts by title, and what is said of each."""
    answers = [(title, answer(text)) for title, text in wrong_texts()]
    return "".join(f"# {title}\n{said}\n\n" for title, said in answers if said)


def condensed() -> str:
    """The schema without loss: every different part of it once, a line each, and its number where it occurs."""
    numbers: dict[str, int] = {}

    def number(part: Any) -> Any:
        if isinstance(part, list):
            return [number(entry) for entry in part]
        if not isinstance(part, Mapping):
            return part
        line = json.dumps({key: number(value) for key, value in part.items()}, ensure_ascii=False)
        return f"#{numbers.setdefault(line, len(numbers))}"

    number(schema())
    return "".join(f"#{n} {line}\n" for line, n in numbers.items())


def kinds_told() -> str:
    """What `rattle kinds` prints, and what it prints of every kind and topic."""
    every = ["", *registry.families(), *topics()]
    return "\n".join(f"$ rattle kinds {name}\n" + CliRunner().invoke(kinds, name.split()).output for name in every)


if __name__ == "__main__":
    for place, told in ((REFUSALS, refusals()), (SCHEMA, condensed()), (KINDS, kinds_told())):
        place.write_text(told, encoding="utf-8")
