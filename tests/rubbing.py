"""Mechanisms whose joints rub."""


def block(friction, push="0", more="", x=0):
    """On a rail; more: keys of the rail."""
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.2, v = 1.0, F = 10.0 }}
ground.points.O = [0, 0]
bodies.block = {{ points = {{ C = [0, 0] }}, mass = 2, inertia = 1 }}
loads.push = {{ type = "force", at = "block.C", force = ["{push}", 0] }}
[joints.rail]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = 0
friction = {friction}
{more}
[initial.block]
x = {x}
vx = "v"
"""


def slider_crank(friction, motion="", pin="", begins=""):
    """With friction in its pins and its guide; free without a motion.  pin: keys of that at the slider."""
    if not motion and not begins:
        begins = 'crank = { angle = 0.7, omega = "omega" }'
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.1, omega = 20.0, r = 0.01 }}
{f'drivers.motor = {{ joint = "O", angle = "{motion}" }}' if motion else ""}
ground.points.O = [0, 0]
bodies.crank = {{ points = {{ O = [0, 0], A = [0.05, 0] }}, mass = 0.3, inertia = 1e-4 }}
bodies.rod = {{ bar = ["A", "B"], length = 0.12, mass = 0.21, inertia = 2.5e-4 }}
bodies.slider = {{ points = {{ B = [0, 0] }}, mass = 0.14, inertia = 1e-4 }}
[joints]
O = {{ type = "revolute", connect = ["ground.O", "crank.O"], friction = {friction} }}
A = {{ type = "revolute", connect = ["crank.A", "rod.A"], friction = {friction} }}
B = {{ type = "revolute", connect = ["slider.B", "rod.B"], {pin or f"friction = {friction}"} }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slider.B"]
axis = 0
friction = {{ model = "coulomb", mu = "mu" }}
[initial]
{begins}
"""


def two_shafts(clutch, one, two="0", stop="", pins=('{ torque = "f" }', '{ torque = "g" }'), begins="angle = 0"):
    """Behind a clutch, each in a pin that rubs, with these torques; begins: of the first one, which turns with w."""
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ f = 0.6, g = 0.6, mu = 0.3, w = 0.0 }}
ground.points = {{ O = [0, 0], Q = [1, 0] }}
bodies.one = {{ points = {{ O = [0, 0] }}, mass = 1, inertia = 0.04 }}
bodies.two = {{ points = {{ O = [0, 0] }}, mass = 1, inertia = 0.04 }}
joints.p = {{ type = "revolute", connect = ["ground.O", "one.O"], friction = {pins[0]}{stop} }}
joints.q = {{ type = "revolute", connect = ["ground.Q", "two.O"], friction = {pins[1]} }}
joints.way = {{ type = "clutch", connect = {clutch} }}
loads.a = {{ type = "torque", body = "one", torque = "{one}" }}
loads.b = {{ type = "torque", body = "two", torque = "{two}" }}
initial = {{ one = {{ {begins}, omega = "w" }}, two = {{ angle = 0, omega = 0 }} }}
"""
