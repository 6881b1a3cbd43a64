"""The models in Exudyn: fast build without range checks, no output files, several solvers."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from scoreboard.bodies import GROUND, Bodies, G
from scoreboard.curves import Way

NAME = "Exudyn"
SMALL = 10  # bodies up to which its dense solver is used; beyond, the sparse one is quicker
STEPS = tuple(10 * 4**k for k in range(1, 8))


def package() -> Any:
    """Exudyn, or ImportError."""
    sys.exudynFast = True  # type: ignore[attr-defined]  # read by Exudyn's import
    import exudyn

    exudyn.config.suppressWarnings = True
    exudyn.SetWriteToConsole(False)
    return exudyn


def items() -> Any:
    """What systems are made of."""
    from exudyn import itemInterface

    return itemInterface


def settings(end: float, steps: int, tolerance: float | None = None, modified: bool = False) -> Any:
    """Settings of a run without output."""
    exu = package()
    chosen = exu.SimulationSettings()
    chosen.timeIntegration.endTime = end
    chosen.timeIntegration.numberOfSteps = steps
    chosen.timeIntegration.verboseMode = 0
    chosen.timeIntegration.adaptiveStep = True  # halves steps that do not converge and locates contacts
    chosen.timeIntegration.automaticStepSize = tolerance is not None
    if tolerance is not None:
        chosen.timeIntegration.initialStepSize = end / steps
        chosen.timeIntegration.relativeTolerance = tolerance
        chosen.timeIntegration.absoluteTolerance = tolerance * 1e-2
    chosen.timeIntegration.minimumStepSize = 1e-14
    chosen.timeIntegration.newton.useModifiedNewton = modified
    chosen.solutionSettings.writeSolutionToFile = False
    chosen.linearSolverType = exu.LinearSolverType.EXUdense
    return chosen


def system_of(model: Bodies) -> tuple[Any, list[int]]:
    """Rigid bodies with three coordinates each, pins as constraints."""
    exu, item = package(), items()
    system = exu.SystemContainer().AddSystem()
    nodes, objects = [], []
    for one in model.bodies:
        node = system.AddNode(
            item.NodeRigidBody2D(
                referenceCoordinates=[one.x, one.y, one.angle], initialVelocities=[one.vx, one.vy, one.omega]
            )
        )
        nodes.append(node)
        objects.append(system.AddObject(item.ObjectRigidBody2D(mass=one.mass, inertia=one.inertia, nodeNumber=node)))
        centre = system.AddMarker(item.MarkerBodyPosition(bodyNumber=objects[-1]))
        system.AddLoad(item.LoadForceVector(markerNumber=centre, loadVector=[0, -one.mass * G, 0]))
    ground = system.AddObject(item.ObjectGround())
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0))

    def place(body: int, arm: tuple[float, float]) -> int:
        number = ground if body == GROUND else objects[body]
        return system.AddMarker(item.MarkerBodyPosition(bodyNumber=number, localPosition=[*arm, 0]))

    for pin in model.pins:
        markers = [place(pin.a, pin.at_a), place(pin.b, pin.at_b)]
        system.AddObject(item.ObjectJointRevolute2D(markerNumbers=markers))
    for body in model.sliders:
        for coordinate in (1, 2):
            marker = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[body], coordinate=coordinate))
            system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[fixed, marker]))
    system.Assemble()
    return system, nodes


def implicit(model: Bodies, end: float, name: str, index2: bool, radius: float, modified: bool) -> Way:
    """Generalised-alpha or the trapezoidal rule, with fixed steps."""

    def make(steps: int) -> Callable[[], np.ndarray]:
        exu = package()
        system, nodes = system_of(model)
        chosen = settings(end, steps, modified=modified)
        if len(model.bodies) > SMALL:
            chosen.linearSolverType = exu.LinearSolverType.EigenSparse
        chosen.timeIntegration.generalizedAlpha.spectralRadius = radius
        chosen.timeIntegration.newton.relativeTolerance = 1e-8
        kind = exu.DynamicSolverType.TrapezoidalIndex2 if index2 else exu.DynamicSolverType.GeneralizedAlpha

        def solve() -> np.ndarray:
            run(system, chosen, kind)
            return positions(system, nodes)

        return solve

    return Way(NAME, name, [(f"{steps} steps", lambda steps=steps: make(steps)) for steps in STEPS])


def run(system: Any, chosen: Any, kind: Any) -> None:
    """The solver call.  Raises ValueError where it gives up."""
    try:
        system.SolveDynamic(chosen, solverType=kind, showHints=False)
    except package().SolverError as failure:
        raise ValueError("Exudyn gives up") from failure


def positions(system: Any, nodes: Sequence[int]) -> np.ndarray:
    """x and y of all mass centres [m]."""
    exu = package()
    return np.ravel([system.GetNodeOutput(node, exu.OutputVariableType.Position)[:2] for node in nodes])


def smooth(model: Bodies, end: float) -> list[Way]:
    """Absolute coordinates with constraints."""
    return [
        implicit(model, end, "generalised-alpha 0.9", False, 0.9, False),
        implicit(model, end, "generalised-alpha 0.9, modified Newton", False, 0.9, True),
        implicit(model, end, "generalised-alpha 0.6", False, 0.6, False),
        implicit(model, end, "trapezoidal, index 2", True, 1.0, False),
    ]


# ---------------------------------------------------------------- minimal coordinates
def pendulum_tree(model: Bodies, end: float) -> list[Way]:
    """A chain of bars in minimal coordinates with the explicit solvers; no constraints are left."""
    return [
        _tree(model, end, name, kind, grades)
        for name, kind, grades in (
            ("minimal coordinates, RK44", "RK44", STEPS[:7]),
            ("minimal coordinates, RK67", "RK67", STEPS[:6]),
            ("minimal coordinates, DOPRI5", "DOPRI5", [10.0**-k for k in range(3, 13)]),
        )
    ]


def _tree(model: Bodies, end: float, name: str, kind: str, grades: Sequence[float]) -> Way:
    lengths = [-2 * pin.at_b[0] for pin in model.pins]

    def make(grade: float) -> Callable[[], np.ndarray]:
        exu, item = package(), items()
        system = exu.SystemContainer().AddSystem()
        angles = [one.angle for one in model.bodies]
        relative = [b - a for a, b in zip([0.0, *angles], angles, strict=False)]
        count = len(angles)
        node = system.AddNode(
            item.NodeGenericODE2(
                referenceCoordinates=[0.0] * count, initialCoordinates=relative, initialCoordinates_t=[0.0] * count,
                numberOfODE2Coordinates=count,
            )
        )  # fmt: skip
        inertia = [np.diag([one.inertia, one.inertia, one.inertia]) for one in model.bodies]
        system.AddObject(
            item.ObjectKinematicTree(
                nodeNumber=node,
                gravity=[0, -G, 0],
                jointTypes=[exu.JointType.RevoluteZ] * count,
                linkParents=list(range(-1, count - 1)),
                jointTransformations=exu.Matrix3DList([np.eye(3)] * count),
                jointOffsets=exu.Vector3DList([np.array([lengths[k - 1] if k else 0.0, 0, 0]) for k in range(count)]),
                linkInertiasCOM=exu.Matrix3DList(inertia),
                linkCOMs=exu.Vector3DList([np.array([length / 2, 0, 0]) for length in lengths]),
                linkMasses=[one.mass for one in model.bodies],
            )
        )
        system.Assemble()
        chosen = settings(end, int(grade), None) if grade >= 1 else settings(end, 100, grade)
        solver = getattr(exu.DynamicSolverType, kind)

        def solve() -> np.ndarray:
            run(system, chosen, solver)
            turn = np.cumsum(system.GetNodeOutput(node, exu.OutputVariableType.Coordinates))
            bars = [length * np.array([math.cos(a), math.sin(a)]) for length, a in zip(lengths, turn, strict=True)]
            return np.ravel([sum(bars[:k], np.zeros(2)) + bars[k] / 2 for k in range(count)])

        return solve

    spell = (lambda grade: f"{int(grade)} steps") if grades[0] >= 1 else (lambda grade: f"rtol {grade:.0e}")
    return Way(NAME, name, [(spell(grade), lambda grade=grade: make(grade)) for grade in grades])


# ---------------------------------------------------------------- single coordinates
def ball(end: float, restitution: float) -> list[Way]:
    """A mass on a line, let go from 1 m, on an elastic contact with a restitution (impact model 2)."""

    def make(stiffness: float, steps: int, kind: str) -> Callable[[], np.ndarray]:
        exu, item = package(), items()
        system, (node,), ground = _coordinates(((1.0, 1.0, 0.0),))
        data = system.AddNode(item.NodeGenericData(initialCoordinates=[1.0, 0.0], numberOfDataCoordinates=2))
        falling = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        system.AddLoad(item.LoadCoordinate(markerNumber=falling, load=-G))
        system.AddObject(
            item.ObjectContactCoordinate(
                markerNumbers=[ground, falling],
                nodeNumber=data,
                contactStiffness=stiffness,
                restitutionCoefficient=restitution,
                impactModel=2,
            )
        )
        return _solver(system, (node,), settings(end, steps), getattr(exu.DynamicSolverType, kind), (1.0,))

    return [
        Way(
            NAME,
            f"stiffness {stiffness:.0e} N/m, {name}",
            [(f"{n} steps", lambda n=n, k=stiffness, kind=kind: make(k, n, kind)) for n in (50, 200, 1000, 5000)],
        )
        for kind, name in (("RK44", "RK44"), ("TrapezoidalIndex2", "trapezoidal"))
        for stiffness in (1e4, 1e6, 1e8, 1e10, 1e12)
    ]  # fmt: skip


def sliding(
    end: float, masses: Sequence[tuple[float, float, float]], factors: tuple[float, float], friction: float
) -> list[Way]:
    """One or two coordinates that dry friction couples: (mass, position, speed) each, `factors` of their slip.

    Friction grows linearly up to a slip of `zone`, and is `friction` beyond.
    """

    def make(zone: float, steps: int, kind: str, tolerance: float | None = None) -> Callable[[], np.ndarray]:
        exu, item = package(), items()
        system, nodes, ground = _coordinates(masses)
        markers = [system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=n, coordinate=0)) for n in nodes]
        system.AddObject(
            item.ObjectConnectorCoordinateSpringDamperExt(
                markerNumbers=[ground, *markers] if len(markers) == 1 else markers,
                factor0=factors[0],
                factor1=factors[1],
                dynamicFrictionForce=friction,
                frictionProportionalZone=zone,
            )
        )
        chosen = settings(end, steps, tolerance)
        return _solver(system, nodes, chosen, getattr(exu.DynamicSolverType, kind), [1.0] * len(nodes))

    ways = []
    for zone in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5):
        words = f"zone {zone:.0e} m/s"
        ways += [
            Way(
                NAME,
                f"{words}, trapezoidal",
                [
                    (f"{n} steps", lambda n=n, zone=zone: make(zone, n, "TrapezoidalIndex2"))
                    for n in (25, 100, 400, 1600, 6400)
                ],
            ),
            Way(
                NAME,
                f"{words}, DOPRI5",
                [
                    (f"rtol {tolerance:.0e}", lambda t=tolerance, zone=zone: make(zone, 100, "DOPRI5", t))
                    for tolerance in (1e-4, 1e-7, 1e-10)
                ],
            ),
        ]
    return ways


def _coordinates(masses: Sequence[tuple[float, float, float]]) -> tuple[Any, list[int], int]:
    """A system of single coordinates, and a marker of the ground."""
    exu, item = package(), items()
    system = exu.SystemContainer().AddSystem()
    nodes = []
    for mass, position, speed in masses:
        node = system.AddNode(
            item.Node1D(referenceCoordinates=[0], initialCoordinates=[position], initialVelocities=[speed])
        )
        system.AddObject(item.ObjectMass1D(mass=mass, nodeNumber=node))
        nodes.append(node)
    fixed = system.AddNode(item.NodePointGround())
    return system, nodes, system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))


def _solver(system: Any, nodes: Sequence[int], chosen: Any, kind: Any, scale: Sequence[float]) -> Any:
    """All coordinates at the end, each times its scale."""
    exu = package()
    system.Assemble()

    def solve() -> np.ndarray:
        run(system, chosen, kind)
        found = [np.ravel(system.GetNodeOutput(node, exu.OutputVariableType.Coordinates))[0] for node in nodes]
        return np.array(found) * scale

    return solve
