"""A ball that falls on a stop, shared by tests of contacts."""

G = 9.81  # [m/s^2]
RIGID = '{ model = "impact", restitution = "e" }'


def ball(contact=RIGID, h=1.0, e=0.8, more="", g=G):
    return f"""
format = 1
gravity = [0, {-g}]
parameters = {{ h = {h}, e = {e}, k = 1e5, lift = 0 }}
ground.points = {{ O = [0, 0], S = [0, -2] }}
bodies.ball = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 1 }}
initial.ball = {{ y = "h", vy = 0 }}
{more}
[joints.rail]
type = "prismatic"
connect = ["ground.O", "ball.C"]
axis = "90 deg"
angle = 0
stop = {{ min = 0, contact = {contact} }}
"""
