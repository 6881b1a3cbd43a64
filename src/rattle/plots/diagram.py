"""The mechanism as put together, before any run: everything in it by name, what drives it and what moves freely."""

from __future__ import annotations

import math
from collections.abc import Iterator
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rattle import registry
from rattle.analyses.assembly.free_coordinates import free_coordinates
from rattle.analyses.assembly.start_constants import as_guessed
from rattle.analyses.load_forces import load_forces
from rattle.description.model import Driver, Model, is_ground, point_of_ground
from rattle.drawings.arrows import Style, Way, straight, turning
from rattle.drawings.forms import drawing_of
from rattle.drawings.played import Stage
from rattle.drawings.sheet import Sheet as DrawingSheet
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.placement import point_at, pose
from rattle.equations.system import System
from rattle.errors import AssemblyError
from rattle.jit import layout as at
from rattle.plots.curves import BLACK, GREY, RED, drawn, figure_of, length_axes, new_figure, tidy
from rattle.plots.figure import Page
from rattle.plots.labels import Label, place_labels
from rattle.plots.scene import Array, Scene
from rattle.plots.sketch import draw_layers, draw_mechanism, extent
from rattle.results.build import build_result
from rattle.results.display import quantity
from rattle.results.handy_units import written_units
from rattle.results.trust import Trust

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.analyses.analysed_model import AnalysedModel

ROOM = 0.2  # around the mechanism, as a share of its size
FORCE, MOMENT, DRIVE, FREE = 0.13, 0.07, 0.055, 0.045  # length of an arrow, radii of arcs: same share
TOGETHER = 1e-6  # distance of points that have one name, and gap that is open: same share
SWEEP = 3.6  # of an arc [rad]
WIDTH, DASH = 1.9, (5.6, 3.7)  # of an arrow, and of the strokes and gaps of one that stands for nothing yet [pixels]
MANY = 8  # free coordinates that are listed, and up to which they are marked
WIDE = 110  # characters of a line below the title
LABEL = 40  # characters of a line of a label


class Sheet(NamedTuple):
    """How wide and how high axes are at most, and how high at least [inches]."""

    wide: float
    high: float
    flattest: float


OWN = Sheet(8.0, 7.6, 2.6)


class Position(NamedTuple):
    """A system with its bodies placed."""

    system: System
    q: Array  # (3 nb,)
    v: Array
    reason: str  # why the joints cannot be closed; "" if they are

    def point(self, body: str, spot: Any) -> Array:
        """(2,) a point of a body [m]."""
        x, y, angle = pose(self.system, self.q, body)
        c, s = math.cos(angle), math.sin(angle)
        return np.array([x + c * spot[0] - s * spot[1], y + s * spot[0] + c * spot[1]])


class Arrows:
    """Arrows in a drawing that rests; places and lengths in m."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.size = scene, scene.size
        self.sheet = DrawingSheet(scene.result.geometry)

    def straight(self, start: Array, way: Array, style: Style) -> Array:
        """An arrow from `start` by `way` (2,).  Returns its tip (2,)."""
        straight(self.sheet, self.sheet.spot(*start), Way(*way), style)
        return start + way

    def turning(self, centre: Array, radius: float, start: float, style: Style, sense: float = 1.0) -> Array:
        """An arc about `centre` from the angle `start` [rad], clockwise where sense < 0.  Returns its middle (2,)."""
        angles = (start, SWEEP) if sense >= 0.0 else (start + SWEEP, -SWEEP)
        turning(self.sheet, self.sheet.spot(*centre), radius, angles, style)
        middle = start + 0.5 * SWEEP
        return centre + radius * np.array([math.cos(middle), math.sin(middle)])

    def stage(self) -> Stage:
        """All of them, to be drawn."""
        return Stage(self.sheet.written(), self.sheet.geometry, self.scene, self.size)


def plot_model(m: AnalysedModel, ax: Axes | None = None, sheet: Sheet | None = None) -> Figure | Axes:
    """See `Mechanism.plot`; sheet: of a new picture without a title, for a page that has one."""
    position = _position(m)
    scene = _scene(position)
    low, high = extent(scene)
    size = float(max(high - low)) or 1.0
    scene = scene._replace(size=size)
    low, high = low - ROOM * size, high + ROOM * size
    asked, ax = ax, ax if ax is not None else _axes(high - low, sheet or OWN)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    tidy(ax).grid(False)
    length_axes(ax, float(max(high - low)), written_units(m.to_json()))
    draw_mechanism(ax, scene, names=False)
    arrows = Arrows(scene)
    labels = [*_joints(scene, position), *_bodies(ax, scene, position), *_points(ax, scene, position)]
    labels += [*_drivers(arrows, position), *_loads(arrows, position), *_gravity(ax, arrows, position.system.model)]
    free = () if position.reason else free_coordinates(position.system, 0.0, position.q)
    if len(free) <= MANY:
        _mark_free(arrows, position, free)
    draw_layers(ax, scene, arrows.stage(), ("drawn",))
    labels += _open_joints(ax, scene, position)
    _say(ax, position, free, sheet)
    place_labels(ax, labels)
    if asked is None:
        figure_of(ax).set_layout_engine("none")  # names are placed for this layout
    return drawn(ax, asked)


def drawing(m: AnalysedModel) -> str:
    """The drawing as an SVG element of a page; "" of a mechanism without bodies."""
    if not m.model.moving_bodies:
        return ""
    figure = plot_model(m)
    assert isinstance(figure, Page), "without axes given it is a new figure"
    return figure.to_page(f"drawing of {m.name or 'the mechanism'}")


def _position(m: AnalysedModel) -> Position:
    """The assembled start, or else the first guess for it."""
    try:
        return Position(m.system, m.start.q, m.start.v, "")
    except AssemblyError as error:
        system, q = as_guessed(m.model)
        return Position(system, q, np.zeros_like(q), str(error))


def _scene(position: Position) -> Scene:
    system = position.system
    names = [f"{body}.{key}" for body in system.bodies for key in ("x", "y", "angle")]
    units = {name: "rad" if name.endswith(".angle") else "m" for name in names}
    result = build_result(
        system.model, "assembly", t=[0.0], data=position.q[None], names=names, units=units, trust=Trust(drift=0.0)
    )
    return Scene(result, np.array([0]), system.extent)


def _axes(span: Array, sheet: Sheet) -> Axes:
    """Axes of a new figure for a picture of so many metres across and upwards."""
    height = float(np.clip(sheet.wide * span[1] / span[0], sheet.flattest, sheet.high))
    width = float(np.clip(height * span[0] / span[1], 0.8 * sheet.wide, sheet.wide))
    return new_figure(width + 0.8, height + 1.4).subplots()


# ---------------------------------------------------------------- names, and what is drawn with them
Place = tuple[Array, list[str], list[str]]  # a spot, the joints and the points there


def _joints(scene: Scene, position: Position) -> Iterator[Label]:
    """Joints by name, with their play; those at one place have one label, and so have points of other names there."""
    places: list[Place] = []
    for joint_name, form in scene.result.geometry["joints"].items():
        how = drawing_of("joint", form["type"])
        if how is None:
            continue
        a, b = (end[0] for end in scene.ends(form))
        spot = a + how.name_at * (b - a)
        loose = form["clearance"] > 0.0 and form["contact"] != "ideal"
        name = f"{joint_name} (play {quantity(form['clearance'], 'm')})" if loose else joint_name
        place = _shared(places, spot, TOGETHER * scene.size)
        place[1].append(name)
        joint = position.system.model.joints[joint_name]
        ends = zip((joint.a, joint.b), (a, b), strict=True)
        place[2].extend(point.name for point, end in ends if np.hypot(*(end - spot)) < TOGETHER * scene.size)
    joints = position.system.model.joints
    for spot, names, points in places:
        more = ", ".join(dict.fromkeys(point for point in points if point and point not in joints))
        text = fill(", ".join(names) + (f" ({more})" if more else ""), LABEL)
        yield Label(text, (float(spot[0]), float(spot[1])))


def _shared(places: list[Place], spot: Array, reach: float) -> Place:
    """The place that is as near to a spot as this [m], or else a new one there."""
    for place in places:
        if float(np.hypot(*(place[0] - spot))) < reach:
            return place
    places.append((spot, [], []))
    return places[-1]


def _bodies(ax: Axes, scene: Scene, position: Position) -> Iterator[Label]:
    """Bodies by name at their mass centres, which are marked."""
    for body in position.system.model.moving_bodies:
        x, y = position.point(body, (0.0, 0.0))
        ax.plot(
            [x],
            [y],
            "o",
            markersize=6.5,
            markerfacecolor="white",
            markeredgecolor=BLACK,
            markeredgewidth=0.8,
            zorder=4.5,
        )
        ax.plot([x], [y], "+", markersize=6.5, markeredgecolor=BLACK, markeredgewidth=0.8, zorder=4.6)
        yield Label(body, (float(x), float(y)), scene.colour(body), "italic", 9.5)


def _points(ax: Axes, scene: Scene, position: Position) -> Iterator[Label]:
    """Named points that no joint has, as dots."""
    model = position.system.model
    ends = [end for joint in model.joints.values() for end in (joint.a, joint.b)]
    taken = {(end.body, end.name) for end in ends}
    taken |= {("ground", point_of_ground(end.body)) for end in ends if is_ground(end.body)}
    every = [("ground", name, spot) for name, spot in model.ground.items()]
    every += [(body, name, spot) for body, its in model.bodies.items() for name, spot in its.points.items()]
    for body, name, spot in every:
        if (body, name) in taken:
            continue
        x, y = position.point(body, spot)
        ax.plot([x], [y], "o", markersize=3.5, color=BLACK, zorder=4.7)
        yield Label(name, (float(x), float(y)), GREY, size=8.0)


def _drivers(arrows: Arrows, position: Position) -> Iterator[Label]:
    """Drivers as arrows of what they move: an arc, or an arrow along the line."""
    system = position.system
    workspace = system.workspace()
    open_by(workspace, 0.0, position.q, position.v)
    for name, driver in system.model.motors.items():
        spot = _driven_point(position, driver)
        row = workspace.rows[system.first_row(name)]
        way = np.array([row[at.BX], row[at.BY]])
        if driver.sets_angle or not np.hypot(*way) > 0.0:
            tip = arrows.turning(spot, DRIVE * arrows.size, -0.6, Style("black", WIDTH))
        else:
            n = np.array([-way[1], way[0]])
            start = spot + (0.07 * n - 0.06 * way) * arrows.size
            tip = arrows.straight(start, 0.12 * arrows.size * way, Style("black", WIDTH)) - 0.06 * arrows.size * way
        yield Label(name, (float(tip[0]), float(tip[1])), BLACK, "italic")


def _driven_point(position: Position, driver: Driver) -> Array:
    point = position.system.model.joints[driver.joint].b if driver.point is None else driver.point
    return point_at(position.system, position.q, point)


def _loads(arrows: Arrows, position: Position) -> Iterator[Label]:
    """Springs and the like by name; other loads as arrows of what they exert at the start, broken lines if nothing."""
    system = position.system
    exerted = load_forces(system, 0.0, position.q, position.v)
    for name, load in system.model.loads.items():
        how = drawing_of("load", load.kind)
        if how is not None:
            a, b = (point_at(system, position.q, end) for end in (load.a, load.b))
            spot = a + how.name_at * (b - a)
            yield Label(name, (float(spot[0]), float(spot[1])), RED)
            continue
        fields = registry.kinds("load")[load.kind].fields.values()
        turns = any(field.unit == "N*m" for field in fields) and not any(field.unit == "N" for field in fields)
        for k, end in enumerate((load.b, load.a)):
            if is_ground(end.body):
                continue
            effect = exerted[name][1 + system.bodies.index(end.body)]
            if k and not np.any(effect):
                continue
            tip = _exerted(arrows, position, point_at(system, position.q, end), end.body, effect, turns)
            if not k:
                yield Label(name, (float(tip[0]), float(tip[1])), RED)


def _exerted(arrows: Arrows, position: Position, spot: Array, body: str, effect: Array, turns: bool) -> Array:
    """Arrows of a force and a moment (3,) [N, N*m] on a body at one of its points; returns a tip (2,) [m]."""
    size, force = arrows.size, float(np.hypot(effect[0], effect[1]))
    arm = spot - position.point(body, (0.0, 0.0))
    moment = float(effect[2] - (arm[0] * effect[1] - arm[1] * effect[0]))
    nothing = not np.any(effect)
    style = Style("red", WIDTH, dash=DASH if nothing else ())
    tip = spot
    if abs(moment) > 1e-9 * force * size or (nothing and turns):
        tip = arrows.turning(spot, MOMENT * size, 0.9, style, 1.0 if nothing else moment)
    if force > 0.0 or (nothing and not turns):
        way = effect[:2] / force if force > 0.0 else np.array([1.0, 0.0])
        tip = arrows.straight(spot, FORCE * size * way, style)
    return tip


def _gravity(ax: Axes, arrows: Arrows, model: Model) -> Iterator[Label]:
    """The direction of gravity, in the upper right corner."""
    g = np.array(model.gravity)
    strength = float(np.hypot(*g))
    if not strength > 0.0:
        return
    (_, right), (_, top) = ax.get_xlim(), ax.get_ylim()
    middle, way = np.array([right, top]) - 0.08 * arrows.size, arrows.size * g / strength
    tip = arrows.straight(middle - 0.05 * way, 0.1 * way, Style("grey", WIDTH))
    yield Label("g", (float(tip[0]), float(tip[1])), GREY, "italic")


def _mark_free(arrows: Arrows, position: Position, free: tuple[str, ...]) -> None:
    """Free coordinates of joints as thin broken arrows with two heads."""
    style = Style("grey", 1.2, 5.5, (3.6, 2.4), both=True)
    for name in free:
        joint = position.system.model.joints.get(name.rpartition(".")[0])
        if joint is None or joint.leaf.motor is None or not name.endswith(f".{joint.leaf.motor.driver}"):
            continue
        spot = point_at(position.system, position.q, joint.b)
        if registry.kinds("driver")[joint.leaf.motor.driver].leaf.sets_angle:
            arrows.turning(spot, FREE * arrows.size, 1.2, style)
        else:
            angle = pose(position.system, position.q, joint.a.body)[2] + (joint.line or 0.0)
            u, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
            arrows.straight(spot + arrows.size * (0.06 * n - 0.06 * u), 0.12 * arrows.size * u, style)


def _open_joints(ax: Axes, scene: Scene, position: Position) -> Iterator[Label]:
    """Joints that do not close in the guessed position: a red line between their two points."""
    if not position.reason:
        return
    system = position.system
    workspace = system.workspace()
    open_by(workspace, 0.0, position.q, position.v)
    for name, joint in system.model.joints.items():
        rows = [k for k, row in enumerate(system.rows) if row.owner == name and row.unit == "m"]
        gap = float(np.linalg.norm(workspace.rows[rows, at.RES]))
        if gap <= TOGETHER * scene.size:
            continue
        a, b = (point_at(system, position.q, end) for end in (joint.a, joint.b))
        if joint.line is not None:  # the nearest point of the line
            angle = pose(system, position.q, joint.a.body)[2] + joint.line
            u = np.array([math.cos(angle), math.sin(angle)])
            a = a + ((b - a) @ u) * u
        ax.plot(
            *np.array([a, b]).T, color=RED, linewidth=1.6, linestyle=(0, (3, 1.5)), marker="x", markersize=9, zorder=7
        )
        middle = 0.5 * (a + b)
        yield Label(f"{name} open by {quantity(gap, 'm', 3)}", (float(middle[0]), float(middle[1])), RED, size=9.5)


# ---------------------------------------------------------------- what is said
def _say(ax: Axes, position: Position, free: tuple[str, ...], sheet: Sheet | None) -> None:
    """The title, below it what there is and what moves; below the picture why it does not close."""
    model = position.system.model
    counts = [_count(len(model.moving_bodies), "body", "bodies"), _count(len(model.joints), "joint", "joints")]
    text = ", ".join(counts)
    if model.motors:
        text += "; driven: " + ", ".join(_driven(model, name, driver) for name, driver in model.motors.items())
    if free:
        many = f" and {len(free) - MANY} more" if len(free) > MANY else ""
        text += f"; {_count(len(free), 'degree', 'degrees')} of freedom: {', '.join(free[:MANY])}{many}"
    elif position.reason:
        text += "; not put together: bodies as first guessed"
    elif position.system.row_count <= LARGE:
        text += "; nothing else is free" if model.motors else "; no degree of freedom"
    wide = WIDE if sheet is None else int(WIDE * 0.8 * sheet.wide / OWN.wide)
    lines = fill(text, wide)
    ax.annotate(
        lines, (0, 1), (0, 4), "axes fraction", "offset points", color=GREY, fontsize=8, va="bottom", parse_math=False
    )
    pad = 8 + 10.5 * (lines.count("\n") + 1)
    if sheet is None:
        ax.set_title(model.name or "mechanism", loc="left", fontsize=11, pad=pad, parse_math=False)
    if position.reason:
        ax.annotate(
            fill(position.reason, wide), (0, 0), (0, -34), "axes fraction", "offset points", color=RED, fontsize=8.5,
            va="top", parse_math=False,
        )  # fmt: skip


def _count(n: int, single: str, many: str) -> str:
    return f"{n} {single if n == 1 else many}"


def _driven(model: Model, name: str, driver: Driver) -> str:
    """ "crank.angle by motor", in the names of coordinates."""
    if driver.point is None:
        return f"{driver.joint}.{driver.kind} by {name}"
    place = f"{driver.point.body}.{driver.point.name}" if driver.point.name else driver.point.body
    return f"{place}.{driver.kind.rpartition('-')[2]} by {name}"
