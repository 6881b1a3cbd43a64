"""Bodies on surfaces: texts of models whose motion is known, and what their runs say."""

import math

import numpy as np

import rattle as rt

G = 9.81
EXACT = {"rtol": 1e-11, "atol": 1e-13}


def impact(e=0.0, mu=0.0, more=""):
    """A rigid contact."""
    return f'{{ model = "impact", restitution = {e}, friction = {mu}{more} }}'


def body(name, points, mass, inertia, start, joints=""):
    """A body given about its mass centre; start: x, y, angle, vx, vy, omega."""
    keys = ("x", "y", "angle", "vx", "vy", "omega")
    written = ", ".join(f"{key} = {value}" for key, value in zip(keys, start, strict=True))
    named = ", ".join(f"{key} = [{x}, {y}]" for key, (x, y) in points.items())
    given = f"points = {{ {named} }}, center = [0, 0], mass = {mass}, inertia = {inertia}"
    return f"bodies.{name} = {{ {given} }}\ninitial.{name} = {{ {written} }}\n{joints}"


def surface(name, a, b, contact, axis="0 deg", more=""):
    """A joint `surface`; more: its other keys, after a comma."""
    line = f'axis = "{axis}", ' if axis else ""
    return f'joints.{name} = {{ type = "surface", connect = ["{a}", "{b}"], {line}contact = {contact}{more} }}\n'


def world(*parts, gravity=G, points="O = [0, 0]"):
    """The mechanism of these bodies and joints."""
    return rt.loads(f"format = 1\ngravity = [0, {-gravity}]\nground.points = {{ {points} }}\n" + "".join(parts))


def disc(contact, start=(0.0, 0.1, 0.0, 0.0, 0.0, 0.0), r=0.1, mass=2.0, slope=0.0, gravity=G, more=""):
    """A solid disc on a line of the ground that falls to the right by `slope` [rad]."""
    floor = surface("floor", "ground.O", "disc.C", contact, f"{-math.degrees(slope)!r} deg", f", roller = {r}{more}")
    return world(body("disc", {"C": (0, 0)}, mass, 0.5 * mass * r * r, start), floor, gravity=gravity)


def on_slope(slope, height, v=0.0):
    """Start of a body so far over the origin of a slope that it is turned by, with the speed v down it."""
    s, c = math.sin(slope), math.cos(slope)
    return (height * s, height * c, -slope, v * c, -v * s, 0.0)


def block(half, high, contact, slope=0.0, start=None, mass=3.0, more="", points="O = [0, 0]"):
    """A block, twice as wide and high, on a slope that falls to the right by `slope` [rad]."""
    corners = {"P": (-half, -high), "Q": (half, -high), "T": (-half, high)}
    inertia = mass * (half**2 + high**2) / 3
    floor = surface(
        "floor", "ground.O", "block.P", contact, f"{-math.degrees(slope)!r} deg", ', corners = ["P", "Q", "T"]'
    )
    return world(body("block", corners, mass, inertia, start or on_slope(slope, high)), floor, more, points=points)


def events(r, kind="impact", joint=""):
    """Events of one kind at a joint."""
    return [event for event in r.events if event.kind == kind and str(event.joint).startswith(joint)]


def way(r, name, slope=0.0):
    """What a body has gone down a slope [m]."""
    x, y = r[f"{name}.x"] - r[f"{name}.x"][0], r[f"{name}.y"] - r[f"{name}.y"][0]
    return x * math.cos(slope) - y * math.sin(slope)


def columns(r, *names):
    """Columns of a run side by side."""
    return np.array([r[name] for name in names]).T
