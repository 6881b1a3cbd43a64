"""Model texts of straight bars that bear something, shared by tests of strength."""

IRON = """
[materials.iron]
E = "210 GPa"
nu = 0.3
density = "7850 kg/m^3"
yield = "300 MPa"
ultimate = "500 MPa"
endurance = "80 MPa"
endurance_cycles = 1e6
exponent = 5
"""
SQUARE = '{ shape = "rectangle", width = "10 mm", height = "10 mm" }'  # A 1e-4 m^2, I 1e-8/12 m^4, W 1e-6/6 m^3
HELD = {
    "pins": """joints.A = { type = "revolute", connect = ["ground.O", "bar.A"] }
joints.B = { type = "slot", connect = ["ground.Q", "bar.B"], axis = 0 }""",
    "clamped": 'joints.A = { type = "fixed", connect = ["ground.O", "bar.A"] }',
}


def beam(more="", held="pins", gravity=0.0, body="", length=0.3, section=SQUARE, material=IRON):
    """A bar along x that rests: on two pins, the second of which gives way along it, or clamped at A."""
    return f"""
format = 1
gravity = [0, {-gravity}]
ground.points = {{ O = [0, 0], Q = [{length}, 0], S = [{length / 3!r}, 0.2] }}
{HELD[held]}
{more}
[bodies.bar]
bar = ["A", "B"]
length = {length}
section = {section}
material = "iron"
{body}
{material}"""


def turning(body="", speed=300.0, length=0.5, more=""):
    """A bar that turns about its end A."""
    return f"""
format = 1
ground.points = {{ O = [0, 0] }}
joints.O = {{ type = "revolute", connect = ["ground.O", "bar.A"] }}
drivers.motor = {{ joint = "O", angle = "{speed}*t" }}
{more}
[bodies.bar]
bar = ["A", "B"]
length = {length}
section = {SQUARE}
material = "iron"
{body}
{IRON}"""


def slider_crank(more="", rod="mass = 0.21", drive='joint = "O", angle = "50*t"', gas=-500.0):
    """A slider-crank whose crank and rod are bars."""
    return f"""
format = 1
gravity = [0, -9.81]
ground.points = {{ O = [0, 0] }}
bodies.slider = {{ points = {{ B = [0, 0] }}, mass = 0.4, inertia = 1e-4 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "crank.O"] }}
joints.A = {{ type = "revolute", connect = ["crank.A", "rod.A"] }}
joints.B = {{ type = "revolute", connect = ["rod.B", "slider.B"] }}
joints.guide = {{ type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }}
drivers.motor = {{ {drive} }}
loads.gas = {{ type = "force", at = "slider.B", force = [{gas}, 0] }}
initial = {{ crank = {{ angle = 0.3 }} }}
simulate = {{ t_end = 0.1 }}
{more}
[bodies.crank]
bar = ["O", "A"]
length = 0.05
section = {SQUARE}
material = "iron"
[bodies.rod]
bar = ["A", "B"]
length = 0.12
section = {SQUARE}
material = "iron"
{rod}
{IRON}"""
