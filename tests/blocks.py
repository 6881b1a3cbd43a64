"""A block that slides on a floor, into a wall."""


def block(more="", vx='"v"'):
    """A block on a floor that slides and may turn."""
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.3, v = 1.0, F = 0.0 }}
ground.points.O = [0, 0]
[bodies.block]
points = {{ C = [0, 0], P = [-0.2, -0.1], Q = [0.2, -0.1] }}
mass = 2
inertia = 0.03
[joints.floor]
type = "surface"
connect = ["ground.O", "block.C"]
axis = 0
corners = ["P", "Q"]
contact = {{ model = "impact", restitution = 0, friction = "mu" }}
[initial]
block = {{ x = 0, y = 0.1, angle = 0, vx = {vx}, vy = 0, omega = 0 }}
{more}
"""


def against_a_wall(law="newton"):
    """The block slides on both corners into a rough wall: three contacts with friction at once."""
    wall = f"""
[ground.points]
O = [0, 0]
W = [0.5, 0]
[joints.wall]
type = "surface"
connect = ["ground.W", "block.C"]
axis = "90 deg"
corners = ["R"]
contact = {{ model = "impact", restitution = 0, friction = "mu", restitution_law = "{law}" }}
"""
    text = block().replace("ground.points.O = [0, 0]\n", "").replace("Q = [0.2, -0.1]", "Q = [0.2, -0.1], R = [0.2, 0]")
    head, tail = text.replace("restitution = 0, ", f'restitution = 0, restitution_law = "{law}", ').split("[initial]")
    return head + wall + "[initial]" + tail


def undamped():
    """A block on a rail that is pushed to and fro between two springs without damping."""
    return """
format = 1
parameters = { F = 10.0, M = 2.0, v = 0.39, d = 0.0 }
ground.points.O = [0, 0]
bodies.block = { points = { C = [0, 0] }, mass = "M", inertia = 1 }
loads.push = { type = "force", at = "block.C", force = ["F*sin(7*t)", 0] }
initial.block = { x = 0, vx = "v" }
[joints.rail]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = 0
[joints.rail.stop]
min = -0.15
max = 0.12
contact = { model = "hertz", stiffness = 2e4, exponent = 1, damping = "d" }
"""
