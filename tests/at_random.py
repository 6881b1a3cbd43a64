"""Random mechanisms: a tree of pins and sliders, rods that close loops, drivers that may or may not go together."""

import math

import numpy as np

import rattle as rt

MOTIONS = ("{0} + {1}*t", "{0} + {1}*sin(5*t)", "{0} + {1}*t**2", "{0} + {1}*max(0, t - 0.03)", "{0}")


def turned(angle, at):
    """A vector of a body in the ground frame."""
    return np.array(
        [math.cos(angle) * at[0] - math.sin(angle) * at[1], math.sin(angle) * at[0] + math.cos(angle) * at[1]]
    )


def mechanism(seed):
    """One to five bodies in a pose that closes; the drivers start in it."""
    rng = np.random.default_rng(seed)
    m = rt.Mechanism(f"random {seed}", gravity=[0, -9.81] if rng.random() < 0.7 else [0, 0])
    points = {"ground": {f"G{k}": rng.uniform(-1, 1, 2) for k in range(3)}}
    pose = {"ground": (np.zeros(2), 0.0)}
    m.ground(**{name: [float(x) for x in at] for name, at in points["ground"].items()})

    def place(body, point):
        return pose[body][0] + turned(pose[body][1], points[body][point])

    hinges = []
    for k in range(int(rng.integers(1, 6))):
        body, parent = f"b{k}", "ground" if k == 0 or rng.random() < 0.3 else f"b{rng.integers(0, k)}"
        points[body] = {
            name: rng.uniform(-0.5, 0.5, 2) * rng.uniform(0.2, 1) * 10 ** rng.uniform(-1, 1) for name in "ABC"
        }
        shown = {name: [float(x) for x in at] for name, at in points[body].items()}
        m.body(body, mass=float(10 ** rng.uniform(-2, 2)), inertia=float(10 ** rng.uniform(-3, 1)), points=shown)
        on, angle = str(rng.choice(["G0", "G1", "G2"] if parent == "ground" else ["B", "C"])), float(rng.uniform(-3, 3))
        pose[body] = (place(parent, on) - turned(angle, points[body]["A"]), angle)
        relative = angle - pose[parent][1]
        if rng.random() < 0.75:
            m.revolute(f"j{k}", f"{parent}.{on}", f"{body}.A")
            hinges.append((f"j{k}", relative))
        else:
            m.prismatic(f"j{k}", f"{parent}.{on}", f"{body}.A", axis=float(rng.uniform(-3, 3)), angle=relative)
        m.initial(body, x=float(pose[body][0][0]), y=float(pose[body][0][1]), angle=angle)
    bodies = list(pose)[1:]
    for k in range(int(rng.integers(0, 3))):
        one, other = str(rng.choice(bodies)), str(rng.choice(list(pose)))
        at = str(rng.choice(["G0", "G1", "G2"])) if other == "ground" else "C"
        length = float(np.linalg.norm(place(one, "B") - place(other, at)))
        if one != other and length > 1e-3:
            m.rod(f"rod{k}", f"{other}.{at}", f"{one}.B", length=length)
    for k in rng.permutation(len(hinges))[: int(rng.integers(0, 3))]:
        name, relative = hinges[k]
        m.driver(f"motor{k}", name, angle=str(rng.choice(MOTIONS)).format(relative, float(rng.uniform(-20, 20))))
    return m


def open_by(m, r):
    """Largest opening of a joint at the outputs of a result [m or rad], from its curves alone."""
    worst = 0.0

    def frame(body):
        return (0.0, 0.0, 0.0) if body == "ground" else tuple(r[f"{body}.{key}"] for key in ("x", "y", "angle"))

    for joint in m.model.joints.values():
        (ax, ay, a), (bx, by, b) = frame(joint.a.body), frame(joint.b.body)
        (px, py), (qx, qy) = joint.a.at, joint.b.at
        dx = bx + np.cos(b) * qx - np.sin(b) * qy - ax - np.cos(a) * px + np.sin(a) * py
        dy = by + np.sin(b) * qx + np.cos(b) * qy - ay - np.sin(a) * px - np.cos(a) * py
        if joint.kind == "revolute":
            gaps = [np.hypot(dx, dy)]
        elif joint.kind == "rod":
            gaps = [np.hypot(dx, dy) - joint.fields["length"]]
        else:
            axis = a + joint.fields["axis"]
            gaps = [np.cos(axis) * dy - np.sin(axis) * dx, b - a - joint.fields["angle"]]
        worst = max(worst, *(float(np.abs(gap).max()) for gap in gaps))
    return worst
