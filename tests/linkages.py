"""Mechanisms that several tests share, as model texts but for one."""

from rattle import loads


def fourbar_text(
    drive: str, a: float, b: float, c: float, d: float, start: str, loads: str = "", joints: str = ""
) -> str:
    """Crank a from (0, 0), coupler b, rocker c from (d, 0); uniform bars of 1, 2 and 3 kg."""
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
A = [0, 0]
D = [{d}, 0]
[bodies.crank]
bar = ["A", "B"]
length = {a}
mass = 1
[bodies.coupler]
bar = ["B", "C"]
length = {b}
mass = 2
[bodies.rocker]
bar = ["D", "C"]
length = {c}
mass = 3
[joints.A]
type = "revolute"
connect = ["ground.A", "crank.A"]
[joints.B]
type = "revolute"
connect = ["crank.B", "coupler.B"]
[joints.C]
type = "revolute"
connect = ["coupler.C", "rocker.C"]
[joints.D]
type = "revolute"
connect = ["ground.D", "rocker.D"]
{joints}
[drivers.motor]
{drive}
{loads}
[initial]
{start}
"""


def parallelogram(drive: str = 'joint = "A"\nangle = "1 + 2*t"') -> str:
    """Crank and rocker of 0.4 m stay parallel; change points at crank angles k pi."""
    return fourbar_text(drive, 0.4, 1.0, 0.4, 1.0, "coupler = { angle = 0 }\nrocker = { angle = 1 }")


def slider_crank(drive: str = 'joint = "O"\nangle = "7*t"', extra: str = "", crank: str = "{ angle = 0.1 }") -> str:
    """Crank 0.1 m balanced on its axis, uniform rod 0.3 m, slider along x; no gravity."""
    return f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.crank]
points = {{ O = [0, 0], A = [0.1, 0] }}
mass = 0.5
inertia = 2e-3
[bodies.rod]
bar = ["A", "B"]
length = 0.3
mass = 0.6
[bodies.slider]
points = {{ B = [0, 0] }}
mass = 0.8
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
[joints.B]
type = "revolute"
connect = ["slider.B", "rod.B"]
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slider.B"]
[drivers.motor]
{drive}
{extra}
[initial]
crank = {crank}
rod = {{ angle = 0 }}
"""


def paper(load: float = -40.0, gravity: float = 0.0, r: float = 0.005, contact: str = '"massless-link"') -> str:
    """The paper's four-bar with play in the pins O3 and O4."""
    return f"""
format = 1
gravity = [0, {-gravity}]
[parameters]
r = {r}
M = {load}
[ground.points]
O1 = [0, 0]
O4 = [0.81, 0]
[bodies.crank]
bar = ["O1", "O2"]
length = 0.2
mass = 0.5
[bodies.coupler]
bar = ["O2", "O3"]
length = 0.6
mass = 2
[bodies.rocker]
bar = ["O3", "O4"]
length = 0.6
mass = 2
[joints.O1]
type = "revolute"
connect = ["ground.O1", "crank.O1"]
[joints.O2]
type = "revolute"
connect = ["crank.O2", "coupler.O2"]
[joints.O3]
type = "revolute"
connect = ["coupler.O3", "rocker.O3"]
clearance = "r"
contact = {contact}
[joints.O4]
type = "revolute"
connect = ["rocker.O4", "ground.O4"]
clearance = "r"
contact = {contact}
[drivers.motor]
joint = "O1"
angle = "10*t"
[loads.M]
type = "torque"
body = "rocker"
torque = "M"
[initial]
coupler = {{ angle = "60 deg" }}
rocker = {{ angle = "-60 deg" }}
"""


def block_in_guide(
    contact: str, clearance: float, length: float, height: float, gravity: float,
    y: float = 0.0, angle: float = 0.0, vx: float = 0.0, omega: float = 0.0,
) -> str:  # fmt: skip
    """A block of 2 kg in a level guide of the ground; y, angle and rates: those at the start."""
    return f"""
format = 1
gravity = [0, {-gravity}]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1e-3
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
axis = 0
clearance = {clearance}
block = {{ length = {length}, height = {height} }}
contact = {contact}
[initial]
block = {{ x = 0, y = {y}, angle = {angle}, vx = {vx}, vy = 0, omega = {omega} }}
"""


# a stage of a lift whose bars fall onto each other at 0.318 s: a singular position
SCISSOR = """
format = 1
gravity = [0, -9.81]
[ground.points]
F = [0, 0]
[bodies.right]
bar = ["F", "T2"]
length = 0.8
mass = 12
points = { M = [0, 0] }
[bodies.left]
bar = ["G", "T1"]
length = 0.8
mass = 15
points = { M = [0, 0], C = ["80 mm", 0] }
[bodies.table]
points = { T1 = [0, 0], T2 = [0, 0] }
center = [0.3, 0.05]
mass = 60
inertia = 5
[joints.F]
type = "revolute"
connect = ["ground.F", "right.F"]
[joints.M]
type = "revolute"
connect = ["right.M", "left.M"]
[joints.G]
type = "slot"
connect = ["ground.F", "left.G"]
axis = 0
[joints.T1]
type = "revolute"
connect = ["table.T1", "left.T1"]
[joints.T2]
type = "slot"
connect = ["table.T2", "right.T2"]
axis = 0
[loads.cylinder]
type = "actuator"
connect = ["ground.F", "left.C"]
force = "7 kN - 500 N*s/m*cylinder.rate"
[initial]
right = { angle = "25 deg" }
left = { angle = "155 deg" }
"""


BORE, ARM = 0.01, 0.1  # of the parallelogram: radius of its loose bushes, length of crank and rocker [m]


def loose_parallelogram(play, friction, jam="impact", loose="C"):
    """A driven parallelogram with a loose pin: where its bars are in line, its coupler and rocker may lock."""
    text = "format = 1\n[ground.points]\nA = [0, 0]\nD = [0.3, 0]\n"
    for name, ends, length, mass in (
        ("crank", "AB", ARM, 0.2),
        ("coupler", "BC", 0.3, 0.5),
        ("rocker", "DC", ARM, 0.2),
    ):
        text += f'[bodies.{name}]\nbar = ["{ends[0]}", "{ends[1]}"]\nlength = {length}\nmass = {mass}\n'
    contact = f'model = "impact", bush_radius = {BORE}, restitution = 0.5, friction = {friction}, jam = "{jam}"'
    pins = (("A", "ground", "crank"), ("D", "ground", "rocker"), ("B", "crank", "coupler"), ("C", "coupler", "rocker"))
    for name, one, other in pins:
        text += f'[joints.{name}]\ntype = "revolute"\nconnect = ["{one}.{name}", "{other}.{name}"]\n'
        text += f"clearance = {play}\ncontact = {{ {contact} }}\n" if name in loose else ""
    text += '[drivers.m]\njoint = "A"\nangle = "0.7 + 10*t"\n'
    return loads(text + "[initial]\ncoupler = { angle = 0 }\nrocker = { angle = 0.7 }\n")
