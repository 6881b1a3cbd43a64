"""The tables of the model file: every key once, with its unit, its limits and what it means.

From these lists follow what is read (`read_fields`), the JSON Schema and with it what editors complete (`schema`), what
`rattle kinds` tells (`reference`), and which keys a mechanism that is built in code takes (`builder`).  Joints, loads,
drivers and laws have their own keys in the classes of their kinds, see `rattle.registry`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from rattle.catalogue import fits
from rattle.registry import REQUIRED, Field

DISTRIBUTIONS = ("uniform", "normal", "triangular")
CURVES = ("linear", "monotone", "spline")  # kinds of table
LONGEST_LABEL = 60  # characters: what fits beside or above a slider; a description may be longer
DEPTHS = "depths"  # key of `wear`: the numbers of a profile, where no file holds them
SIDES = ("bush", "pin")


@dataclass(frozen=True)
class Form:
    """A table with these keys: what may be written there, in this order.

    ways: keys of which exactly one group is given besides; they come first if `ways_first`.
    """

    fields: dict[str, Part]
    meaning: str = ""
    ways: tuple[dict[str, Part], ...] = ()
    ways_first: bool = False

    @property
    def keys(self) -> dict[str, Part]:
        """All keys, those of every way too."""
        first = self.ways[0] if self.ways else {}
        keys = {**first, **self.fields} if self.ways_first else {**self.fields, **first}
        for way in self.ways[1:]:
            keys |= way
        return keys


@dataclass(frozen=True)
class Either:
    """What may be written in one of several forms."""

    forms: tuple[Part, ...]
    meaning: str = ""


OF_PARAMETERS = r"^[A-Za-z_][A-Za-z0-9_]*([.](bore|pin|play))?$"  # with those of fits and bearings


@dataclass(frozen=True)
class Named:
    """A table whose keys are names that the user chooses, each for an entry of this form."""

    entry: Part
    meaning: str
    names: str = r"^[A-Za-z_][A-Za-z0-9_]*$"  # pattern of the names


@dataclass(frozen=True)
class OfKinds:
    """An entry of one of the kinds of a family, with the fields of the kind.

    key: under which the kind is named; "" if it follows from other keys.  common: keys that the entries of all kinds
    have besides, or ways to write such keys.
    """

    family: str
    key: str = "type"
    common: Form = Form({})


Part = Field | Form | Either | Named | OfKinds


def _points(meaning: str, live: bool = False) -> Field:
    return Field("m", meaning, None, shape="points", live=live)


# ---------------------------------------------------------------- bodies and ground
SECTION_SHAPES: dict[str, dict[str, Field]] = {
    "rectangle": {
        "width": Field("m", "across the plane of the mechanism", least="positive"),
        "height": Field("m", "in the plane", least="positive"),
    },
    "round": {"diameter": Field("m", "diameter", least="positive")},
    "tube": {
        "diameter": Field("m", "outer diameter", least="positive"),
        "wall": Field("m", "thickness of its wall", least="positive"),
    },
}
SECTION_NUMBERS = {
    "area": Field("m^2", "area", least="positive"),
    "inertia": Field("m^4", "second moment of area for bending in the plane", least="positive"),
    "modulus": Field("m^3", "section modulus for bending in the plane", least="positive"),
}
MADE_OF = Field("", "of which it is: a name, of [materials] or known", None, shape="material of a body")
THICKNESS = Field("m", "thickness", least="positive")
PLANE = Field("m", "offset of its plane from that of the ground, for bearing moments", 0.0)
BAR = Form(
    {
        "bar": Field("", "names of the ends", shape="names", like='two end names like ["A", "B"]'),
        "length": Field("m", "length", least="positive", missing="a bar needs a length in m"),
        "points": _points("more points, from the mass centre, x axis along the bar"),
        "mass": Field("kg", "mass; default: by section and material", None, least="not negative"),
        "inertia": Field("kg*m^2", "about the mass centre; default m l^2/12", None, least="not negative"),
        "section": Field(
            "",
            "its section, for stresses: "
            + ", ".join(f"{{ shape = {name!r}, ... }}" for name in SECTION_SHAPES)
            + ", or { area, inertia, modulus }",
            None,
            shape="section",
        ),
        "material": MADE_OF,
        "mass_per_length": Field(
            "kg/m",
            "[[x, mass per length], ...], x from the first end, straight between: says mass, centre, inertia",
            None,
            shape="line",
        ),
        "z": PLANE,
    },
    "a straight bar",
)
PLATE = Form(
    {
        "polygon": Field("m", "corners in order around, in any frame of the body", shape="ring"),
        "holes": Field("m", "corners of each hole, in the same frame", None, shape="rings"),
        "points": _points("points in the same frame"),
        "center": Field("m", "mass centre in the same frame, with mass and inertia", None, shape="pair"),
        "inertia": Field("kg*m^2", "about the mass centre, with mass and center", None, least="not negative"),
        "necks": Field(
            "m", "{ name = [[x, y], [x, y]] }: cuts from edge to edge, in the same frame, for stresses there", None,
            shape="cuts",
        ),
        "z": PLANE,
    },
    "a plate: its polygon says mass centre and inertia, unless mass, center and inertia are given",
    ways=(
        {"thickness": THICKNESS, "density": Field("kg/m^3", "density", least="positive"), "material": MADE_OF},
        {"thickness": THICKNESS, "material": replace(MADE_OF, default=REQUIRED)},
        {
            "mass": Field("kg", "mass", least="positive"),
            "thickness": replace(THICKNESS, default=None), "material": MADE_OF,
        },
    ),
)  # fmt: skip
BODY = Form(
    {
        "points": _points("points in any frame of the body"),
        "center": Field("m", "mass centre in the same frame", None, shape="pair"),
        "mass": Field("kg", "mass", least="not negative", missing="needs a mass in kg"),
        "inertia": Field(
            "kg*m^2", "about the mass centre", least="not negative",
            missing="needs an inertia about its mass centre in kg*m^2 (only a bar has a default)",
        ),
        "z": PLANE,
    },
    "a rigid body",
)  # fmt: skip
GROUND = Form({"points": _points("points of the ground, also as functions of t", live=True)})

# ---------------------------------------------------------------- names that expressions use
LIKELY = Field(
    "", "", shape="numbers", fewest=1, like="values",
    missing="expected { values = [...] }, the values that the parameter takes",
)  # fmt: skip
DISTRIBUTION = Form(
    {
        "values": LIKELY,
        "weights": Field("", "", None, shape="numbers", fewest=1, like="weights"),
    },
    "single values, with weights unless all are as likely",
)
VALUE = Field("", "value", shape="expression", missing="expected { value = ... }")
PARAMETER = Form(
    {
        "value": VALUE,
        "min": Field("", "least", None, shape="expression"),
        "max": Field("", "most", None, shape="expression"),
        "tol": Field("", "tolerance: half the width of its field", None, shape="expression"),
        "dist": Either(
            (Field("", "", None, shape="choice", choices=DISTRIBUTIONS), DISTRIBUTION),
            f"distribution: {' | '.join(DISTRIBUTIONS)} on value +- tol, or {{ values = [...], weights = [...] }}",
        ),
        "label": Field("", "what sliders and reports call it", None, shape="text", longest=LONGEST_LABEL),
        "description": Field("", "what a reader should know of it", None, shape="text"),
    }
)
TOLERANCES = Form(
    {
        "groups": Field(
            "", 'parameters that are made together, [["l2", "l3"]]: one draw moves all of a group', None, shape="groups"
        )
    },
    "how the fields of parameters hang together",
)
TABLE = Form(
    {
        "kind": Field(
            "", "straight lines, cubics without overshoot, or cubics with continuous second derivative", CURVES[0],
            shape="choice", choices=CURVES,
        ),
        "period": Field("", "of x, after which y repeats", None, shape="expression", least="positive"),
    },
    ways=(
        {
            "x": Field("", "arguments, increasing", shape="numbers", fewest=2, like="numbers"),
            "y": Field("", "values", shape="numbers", fewest=2, like="numbers"),
            "units": Field(
                "", "units of x and y where numbers have none", None, shape="texts",
                like='the units of x and y, as in ["deg", "mm"]',
            ),
        },
        {"file": Field("", "file beside the model file: two columns, the header may hold units", shape="file")},
    ),
    ways_first=True,
)  # fmt: skip
RATE = Field(
    "",
    "expression over parameters, t, the motion, signals and states, per second",
    shape="expression",
    missing="needs rate: how fast it changes, an expression over parameters, t, states and all",
)
STATE = Form(
    {
        "rate": RATE,
        "start": Field("", "value at the start, default 0", None, shape="quantity"),
    }
)

# ---------------------------------------------------------------- contacts and wear, besides fields of their kinds
FORMULA = Field("", "formula for the stiffness from materials", None, shape="geometry")
BUSH_RADIUS = Field("m", "radius of the bush; the pin radius is smaller by the clearance", None, least="positive")
DAMPING = Field(
    "N*s/m", "c of a compliant contact, F = max(0, F_static + c ddelta), instead of restitution", None,
    least="not negative",
)  # fmt: skip
ROLLING = Field("m", "lever arm of the resistance of a disc that rolls on a surface", None, least="not negative")
CONTACT = Form(
    {
        "rolling": ROLLING,
        "geometry": FORMULA,
        "damping": DAMPING,
        "bush_radius": BUSH_RADIUS,
        "friction": Either(
            (Field("", "coefficient of friction", None, least="not negative"), OfKinds("friction", "model"))
        ),
    }
)
FILM = Field("", "law of the oil film", "finite", shape="film")
OIL = Form(
    {
        "oil": Field(
            "",
            'oil that says viscosity and density: "ISO VG 46", { vg, vi, density } or { nu40, nu100, density }',
            None,
            shape="oil",
        ),
        "temperature": Field("K", "of the oil", None),
        "film": FILM,
        "dry": Field(
            "",
            "the dry contact beside the film: the table of a compliant contact",
            None,
            shape="table",
            like="the table of a compliant contact",
        ),
        "roughness": Either(
            (
                Field("m", "of both surfaces", None, least="not negative"),
                Field("m", "", None, shape="each", least="not negative", like="a number in m, or [bush, pin]"),
            ),
            "root mean square [m]",
        ),
    }
)
MATERIAL = Form({"E": Field("Pa", "modulus", least="positive"), "nu": Field("", "Poisson's ratio", 0.3)})
MATERIAL_OF_MODEL = Form(
    {
        "E": Field("Pa", "modulus", least="positive", missing="needs E, its modulus in Pa"),
        "nu": Field("", "Poisson's ratio", 0.3),
        "density": Field("kg/m^3", "density", None, least="positive"),
        "expansion": Field("1/K", "thermal expansion", None),
        "conductivity": Field("W/(m*K)", "thermal conductivity", None, least="positive"),
        "yield": Field("Pa", "yield strength", None, least="positive"),
        "ultimate": Field("Pa", "ultimate strength", None, least="positive"),
        "endurance": Field(
            "Pa", "amplitude that the part endures at mean stress 0, with notch, surface, size", None, least="positive"
        ),
        "endurance_cycles": Field(
            "", "cycles for which it does, where the line of its lives bends", 1e6, least="positive"
        ),
        "exponent": Field("", "k of N = N_e (S_e/s)^k", None, least="positive"),
    },
    "a material; strengths are those of the part",
)
COEFFICIENT = Form(
    {
        "coefficient": Field("", "of Archard's law, K_a", least="not negative"),
        "hardness": Field("Pa", "H of the softer surface; k = K_a/H", least="positive"),
    },
    "Archard's coefficient over the hardness",
)
LAYER = Form(
    {
        "E": Field("Pa", "modulus of the layer", least="positive"),
        "nu": Field("", "its Poisson's ratio", 0.3, least="not negative"),
        "thickness": Field("m", "of the layer", least="positive"),
    },
    "thin layer { E, nu, thickness } from which the foundation follows",
)
WEAR = Form(
    {
        **{
            side: Either(
                (Field("m^2/N", "k", None, least="not negative"), COEFFICIENT),
                f"k of the {side}, volume lost per force and distance [m^2/N], or {{ coefficient, hardness }}",
            )
            for side in SIDES
        },
        "foundation": Field(
            "Pa/m", "K_w, pressure per penetration; default: fitted to the contact law at a hundredth of the clearance",
            math.nan, least="positive",
        ),
        "bins": Field("", "of the circumference, in which depths are kept", 360.0, least="positive"),
        "smooth": Field(
            "", "D of h_i += D (h_{i-1} - 2 h_i + h_{i+1}) after every jump, 0 to 0.25", 0.0, least="not negative"
        ),
        "cycle": Field(
            "s", "after which the motion repeats; default: one turn of the driver", math.nan, least="positive"
        ),
        "cycles": Field("", "how many", 1e4, least="positive"),
        "wall": Field("m", "depth at which the bush or the pin is worn through", math.inf, least="positive"),
        "limit": Field("m", "depth that is allowed, for the life of the joint", None, least="positive"),
        "band": Field(
            "", "factors of the life that 10 and 90 % reach, for want of a scatter", None, shape="each",
            least="positive", like="two factors of the life, such as [0.3, 3]",
        ),
        "jump": Either(
            (Field("", "", None, shape="constant", choices=("auto",)), Field("", "cycles", None, least="positive")),
            "size of jumps",
        ),
        "layer": LAYER,
        "profile": Field("", "file beside the model file with the depths that are worn", None, shape="file"),
        DEPTHS: Form(
            {side: Field("", "", None, shape="numbers") for side in SIDES},
            "the same, written out: a number for each bin [m]",
        ),
    },
    "how pin and bush wear, for the study of wear",
)  # fmt: skip

# ---------------------------------------------------------------- joints and drivers, besides fields of their kinds
ENDS = Field("", "bush or guide side first", shape="ends", like='["body.point", "body.point"]')
WHOLE_BODIES = Field(
    "", "bodies A and B, or ground", shape="bodies", like='["body", "body"]'
)  # of kinds without points
BODY_TO_DRIVE = Field("", "what is driven", shape="place")
JOINT_TO_DRIVE = Field("", "the joint that is driven", shape="joint", missing="needs joint: the joint to drive")
JOINT_FRICTION = Field(
    "",
    "friction without play: by its own reaction (mu or a law), or stated, { torque } or { force }",
    None,
    shape="own friction",
)
CLEARANCE = Field("m", "radial clearance", None, least="not negative")
PLAY = Form(
    {
        "fit": Field("", 'a fit of ISO 286, such as "H7/g6"', None, shape="text", choices=fits.USUAL),
        "diameter": Field("m", "its nominal size", None, least="positive"),
        "radial": Field("m", "radial play, where no fit says it", None, least="not negative"),
        "bush_material": Field("", "of the bush, for play over temperature", None, shape="material of a body"),
        "pin_material": Field("", "of the pin, for play over temperature", None, shape="material of a body"),
        "temperature": Field("K", "of both; play is stated at 20 degC", None),
        "dist": Field("", "distribution of both diameters", None, shape="distribution"),
    },
    "play by a fit { fit, diameter }, or { radial }, with what it changes by heat",
)
JOINT = Form(
    {
        "connect": ENDS,
        "clearance": Either((CLEARANCE, PLAY), "radial clearance [m], a number or by a fit"),
        "bearing": Field("", 'a rolling bearing that says the clearance, such as "6208 C3"', None, shape="bearing"),
        "contact": Field("", "contact model of the clearance", None, shape="contact"),
        "stop": Field("", "one-sided ends of its coordinate", None, shape="stop"),
        "friction": JOINT_FRICTION,
        "wear": WEAR,
        "length": Field("m", "of the bearing along its pin, for pressures and edge loads", None, least="positive"),
        "z": Field("m", "offset of its middle; default: half way between the planes of its bodies", None),
    }
)
DRIVER = Form(
    {},
    ways=(
        {"joint": JOINT_TO_DRIVE},
        {
            "body": BODY_TO_DRIVE,
            "coordinate": Field("", "of the body", shape="coordinate"),
        },
    ),
)

# ---------------------------------------------------------------- start and run
STATE_UNITS = {"x": "m", "y": "m", "angle": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s"}
START = Form({key: Field(unit, "at the start", None) for key, unit in STATE_UNITS.items()}, "start of a body")
OFFSET = Form({"offset": Field("m", "pin centre minus bush centre", None, shape="pair")}, "start of a clearance joint")
SIMULATE = Form(  # of the meanings, {adaptive} are the steppers that choose their steps, {equal} the others
    {
        "t_end": Field("s", "duration", None, least="positive"),
        "rtol": Field("", "relative error allowed per step of {adaptive}", None, least="positive"),
        "atol": Field("", "error per step that is always allowed to {adaptive}", None, least="positive"),
        "step": Field("s", "length of all steps of {equal}, of the longest one of {adaptive}", None, least="positive"),
        "output": Field("s", "interval between outputs", None, least="positive"),
        "method": Field("", "", None, shape="stepper"),
    }
)

DUTY_CASE = Form(
    {
        "share": Field("", "share of the time, in proportion to the other cases", 1.0, least="positive"),
        "set": Field("", "values of parameters", None, shape="table"),
        "name": Field("", "what reports call it", None, shape="text", longest=LONGEST_LABEL),
    },
    "what the machine does for a share of its time",
)
DUTY = Form({"cases": Field("", "what the machine does, each with its share of the time", None, shape="cases")})
CONDUCTION = Form(
    {
        "between": Field("", "two joints", shape="names", like='two joints like ["A", "B"]'),
        "conductance": Field(
            "W/K", "of what is between them", least="positive", missing="needs its conductance in W/K"
        ),
    },
    "a way of heat between two joints",
)
HEAT = Form(
    {
        "ambient": Field("K", "temperature of the air", None, least="positive"),
        "cooling": Named(Field("W/K", "conductance to the air", least="positive"), "joints and their ways to the air"),
        "conduction": Field("", "ways between joints", None, shape="ways"),
    },
    "where the heat of joints goes",
)
PICTURE = Form(
    {
        "file": Field("", "picture beside the model file", shape="text", longest=200),
        "scale": Field("m", "length of one of its pixels", least="positive"),
        "origin": Field("m", "where its lower left corner is", None, shape="pair"),
        "angle": Field("rad", "by which it is turned", None),
    },
    "a picture below the drawing in the studio; nothing else reads it",
)

# ---------------------------------------------------------------- the whole
MODEL = Form(
    {
        "format": Field("", "version of the format", shape="version"),
        "name": Field("", "title", None, shape="title"),
        "gravity": Field("m/s^2", "acceleration of gravity, also as a function of t", None, shape="pair", live=True),
        "parameters": Named(Either((VALUE, PARAMETER)), "values that expressions use", OF_PARAMETERS),
        "tolerances": TOLERANCES,
        "tables": Named(TABLE, "functions of one number that expressions use: lift(x)"),
        "signals": Named(
            Field("", "expression over parameters, t and state", shape="expression"), "recorded quantities"
        ),
        "states": Named(STATE, "first-order states of the model's own, usable like signals"),
        "ground": GROUND,
        "materials": Named(MATERIAL_OF_MODEL, "materials by name, for bars and bushes", "."),
        "bodies": Named(Either((BAR, PLATE, BODY)), "rigid bodies"),
        "joints": Named(OfKinds("joint", common=JOINT), "joints"),
        "drivers": Named(OfKinds("driver", "", DRIVER), "degrees of freedom that follow a function of time"),
        "loads": Named(OfKinds("load"), "loads"),
        "initial": Named(Either((START, OFFSET)), "start of bodies and of clearance joints"),
        "simulate": SIMULATE,
        "duty": DUTY,
        "heat": HEAT,
        "picture": PICTURE,
    }
)
