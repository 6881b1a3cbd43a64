"""What an .asmt file holds, as records: parts with markers, joints, motions, gravity; lengths in m, angles in rad."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rattle.errors import suggest
from rattle.exchange.asmt.space import Frame, Matrix, Vector, is_rotation, times
from rattle.exchange.asmt.tree import Entry, Tree
from rattle.exchange.refusal import LONGEST, quoted

GROUND = -1  # index of the assembly itself among the parts
JOINTS = {  # kinds that have a counterpart in the plane, with the numbers that they have besides
    "RevoluteJoint": (), "CylindricalJoint": (), "TranslationalJoint": (), "FixedJoint": (),
    "GearJoint": ("radiusI", "radiusJ"), "RackPinionJoint": ("pitchRadius",),
}  # fmt: skip
MOST = 2000  # parts, joints, motions
MOTIONS = {"RotationalMotion": "RotationZ", "TranslationalMotion": "TranslationZ", "AllowRotation": ""}


class Marker(NamedTuple):
    """A frame of a part, in the frame of the part."""

    name: str
    part: int
    frame: Frame


class Part(NamedTuple):
    """A rigid body; its frame and rates are those in the assembly, all else is in its own frame."""

    name: str
    line: int
    frame: Frame
    velocity: Vector  # of its origin [m/s]
    omega: Vector
    mass: float
    inertia: Vector  # principal moments, in the axes of `centre` [kg m^2]
    centre: Frame


class Joint(NamedTuple):
    """What holds marker I and marker J together."""

    name: str
    kind: str
    line: int
    i: Marker
    j: Marker
    numbers: tuple[float, ...] = ()  # radii [m]


class Motion(NamedTuple):
    """A function of time that a joint, or two markers, follow."""

    name: str
    kind: str
    line: int
    i: Marker
    j: Marker
    joint: int  # index of the joint that it names, -1 if it names markers only
    expression: str


class Assembly(NamedTuple):
    """The whole file."""

    name: str
    file: str
    frame: Frame
    parts: tuple[Part, ...]
    joints: tuple[Joint, ...]
    motions: tuple[Motion, ...]
    gravity: Vector
    markers: tuple[Marker, ...]
    times: tuple[float, float, float]  # begin, end, interval of output [s]
    left_out: tuple[str, ...]

    def frame_of(self, part: int) -> Frame:
        """The frame of a part, or of the assembly."""
        return self.frame if part == GROUND else self.parts[part].frame

    def name_of(self, part: int) -> str:
        """The name of a part, for a message."""
        return "the ground" if part == GROUND else self.parts[part].name


def read_assembly(text: str, file: str, unit: float) -> Assembly:
    """Read a file; unit: of its lengths [m].  Raises ModelError with file and line."""
    return _Reader(Tree(text, file), unit).read()


class _Reader:
    def __init__(self, tree: Tree, unit: float) -> None:
        self.tree = tree
        self.unit = unit
        self.markers: dict[str, Marker] = {}  # by the name that joints use
        self.twice: set[str] = set()

    def read(self) -> Assembly:
        tree, top = self.tree, self.tree.top
        name = tree.name(top)
        frame = self.frame(top, "the assembly")
        self.collect(top, f"/{name}", GROUND)
        bodies = list(tree.all(tree.part(top, "Parts"), "Part"))
        sets = tree.part(top, "ConstraintSets")
        many = max(len(bodies), *(len(tree.part(sets, word).inner) for word in ("Joints", "Motions")))
        if not bodies or many > MOST:
            fault = f"{many} parts, joints or motions; at most {MOST} are read" if bodies else "no part"
            raise tree.refused(tree.part(top, "Parts"), f"the assembly {quoted(name)} has {fault}")
        parts = tuple(self.part(entry, name, n) for n, entry in enumerate(bodies))
        joints = tuple(self.joint(entry) for entry in tree.part(sets, "Joints").inner)
        numbers = {f"/{name}/{joint.name}": n for n, joint in enumerate(joints)}
        motions = tuple(self.motion(entry, numbers, joints) for entry in tree.part(sets, "Motions").inner)
        for entry in tree.part(sets, "GeneralConstraintSets").inner:
            raise tree.refused(entry, f"a constraint of unknown kind, {quoted(entry.text)}")
        left = [f"force {self.label(entry)}" for entry in tree.part(top, "ForceTorques").inner]
        if tree.has(sets, "Limits"):
            left += [f"limit {self.label(entry)}" for entry in tree.part(sets, "Limits").inner]
        down = tree.part(top, "ConstantGravity")
        row = tree.row(down, down.inner[0] if down.inner else down, 3, "ConstantGravity")
        run = tree.part(top, "SimulationParameters")
        begin, end, output = (tree.numbers(run, word, 1)[0] for word in ("tstart", "tend", "hout"))
        return Assembly(
            name, tree.file, frame, parts, joints, motions, times(self.unit, _vector(row)),
            tuple(self.markers.values()), (begin, end, output), tuple(left),
        )  # fmt: skip

    # ------------------------------------------------------------ frames and markers
    def frame(self, entry: Entry, of: str) -> Frame:
        """Position and rotation of an entry."""
        tree = self.tree
        origin = times(self.unit, _vector(tree.numbers(entry, "Position3D", 3, of)))
        rotation = tree.part(entry, "RotationMatrix", of)
        if len(rotation.inner) != 3:
            raise tree.refused(rotation, f"{of}: expected 3 rows of a RotationMatrix; is the file complete?")
        x, y, z = (_vector(tree.row(rotation, row, 3, f"{of}: RotationMatrix")) for row in rotation.inner)
        axes: Matrix = (x, y, z)
        if not is_rotation(axes):
            raise tree.refused(rotation, f"{of}: its RotationMatrix turns nothing: it is not orthogonal")
        return Frame(origin, axes)

    def collect(self, entry: Entry, path: str, part: int) -> None:
        """Keep the markers of a part, which stand at its points, curves and surfaces."""
        tree = self.tree
        for word in ("RefPoints", "RefCurves", "RefSurfaces"):
            for place in tree.part(entry, word, path).inner:
                if not tree.has(place, "Markers"):
                    if word == "RefPoints":
                        tree.part(place, "Markers", path)
                    continue
                outer = self.frame(place, f"a point of {path}")
                for marker in tree.all(tree.part(place, "Markers"), "Marker"):
                    name = tree.name(marker)
                    full = f"{path}/{name}"
                    if full in self.markers:
                        self.twice.add(full)
                    self.markers[full] = Marker(name, part, outer.holding(self.frame(marker, f"marker {full}")))

    def marker(self, entry: Entry, word: str, of: str) -> Marker:
        """The marker that a joint names."""
        full = self.tree.text(entry, word, of)
        where = self.tree.part(entry, word).inner[0]
        if full in self.twice:
            raise self.tree.refused(where, f"{of}: {word} {quoted(full)}: two markers have this name")
        if full not in self.markers:
            hint = suggest(full, self.markers) if len(full) <= 2 * LONGEST else ""
            raise self.tree.refused(where, f"{of}: {word}: there is no marker {quoted(full)}{hint}")
        return self.markers[full]

    # ------------------------------------------------------------ parts, joints, motions
    def part(self, entry: Entry, assembly: str, n: int) -> Part:
        tree, name = self.tree, self.tree.name(entry)
        centre = tree.part(entry, "PrincipalMassMarker", name)
        self.collect(entry, f"/{assembly}/{name}", n)
        moments = _vector(tree.numbers(centre, "MomentOfInertias", 3, name))
        (mass,) = tree.numbers(centre, "Mass", 1, name)
        if mass < 0.0 or min(moments) < 0.0:
            raise tree.refused(centre, f"{name}: a mass or moment of inertia is negative")
        return Part(
            name, entry.line, self.frame(entry, name),
            times(self.unit, _vector(tree.numbers(entry, "Velocity3D", 3, name))),
            _vector(tree.numbers(entry, "Omega3D", 3, name)), mass, times(self.unit * self.unit, moments),
            self.frame(centre, f"mass centre of {name}"),
        )  # fmt: skip

    def joint(self, entry: Entry) -> Joint:
        """A joint of a kind that the plane has."""
        tree, kind = self.tree, entry.text
        name = self.label(entry)
        if kind not in JOINTS:
            raise tree.refused(
                entry, f"joint {name}: the kind {quoted(kind)} has no counterpart in the plane;"
                f" known: {', '.join(word.removesuffix('Joint') for word in JOINTS)}",
            )  # fmt: skip
        i, j = (self.marker(entry, word, f"joint {name}") for word in ("MarkerI", "MarkerJ"))
        if i.part == j.part:
            raise tree.refused(entry, f"joint {name}: both markers are on the same part")
        sizes = tuple(self.unit * tree.numbers(entry, word, 1, f"joint {name}")[0] for word in JOINTS[kind])
        return Joint(name, kind, entry.line, i, j, sizes)

    def motion(self, entry: Entry, numbers: Mapping[str, int], joints: tuple[Joint, ...]) -> Motion:
        """A motion, with the markers of the joint that it names."""
        tree, kind, name = self.tree, entry.text, self.label(entry)
        if kind not in MOTIONS:
            raise tree.refused(entry, f"motion {name}: the kind {quoted(kind)} is not taken")
        of, word = f"motion {name}", MOTIONS[kind]
        path = tree.part(entry, "MotionJoint", of)
        full = path.inner[0].text if path.inner else ""
        expression = tree.text(entry, word, of) if word else ""
        if not full:
            i, j = (self.marker(entry, label, of) for label in ("MarkerI", "MarkerJ"))
            return Motion(name, kind, entry.line, i, j, -1, expression)
        if full not in numbers:
            raise tree.refused(path, f"{of}: there is no joint {quoted(full)}{suggest(full[: 2 * LONGEST], numbers)}")
        joint = joints[numbers[full]]
        return Motion(name, kind, entry.line, joint.i, joint.j, numbers[full], expression)

    def label(self, entry: Entry) -> str:
        """The name of an entry for a message or list; its kind if it has none."""
        for part in entry.inner:
            if part.text == "Name" and part.inner:
                return part.inner[0].text
        return entry.text


def _vector(numbers: tuple[float, ...]) -> Vector:
    x, y, z = numbers
    return x, y, z
