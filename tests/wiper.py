"""A windscreen wiper whose rod has a rigid pin with play: between impacts its force towers."""

from __future__ import annotations

import rattle as rt

C, ROD, ARM_MASS, ARM_INERTIA, ARM_CENTRE, PIN = 0.3e-3, 0.25, 0.6, 0.02, 0.22, 0.07
WIPER = f"""
format = 1
[ground.points]
M = [0, 0]
W = [0.28, -0.04]
[bodies.crank]
bar = ["M", "A"]
length = 0.045
mass = 0.1
[bodies.rod]
bar = ["A", "B"]
length = 0.29
mass = {ROD}
[bodies.arm]
points = {{ W = [0, 0], B = [0, {PIN}], T = [0, 0.5] }}
center = [0, {ARM_CENTRE}]
mass = {ARM_MASS}
inertia = {ARM_INERTIA}
[joints.M]
type = "revolute"
connect = ["ground.M", "crank.M"]
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
[joints.B]
type = "revolute"
connect = ["rod.B", "arm.B"]
clearance = {C}
contact = {{ model = "impact", restitution = 0.3, friction = 0.1, bush_radius = "6 mm" }}
[joints.W]
type = "revolute"
connect = ["ground.W", "arm.W"]
[drivers.motor]
joint = "M"
angle = "2*pi*t"
[loads.rubber]
type = "force"
at = "arm.T"
force = ["-4*tanh(arm.T.vx/0.01)", "-4*tanh(arm.T.vy/0.01)"]
[initial]
arm = {{ angle = "-51.7616 deg" }}
"""


def wiper(mu: float, restitution: float = 0.3) -> rt.Mechanism:
    changes = {"joints.B.contact.friction": mu, "joints.B.contact.restitution": restitution}
    return rt.loads(WIPER).set(changes)
