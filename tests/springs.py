"""A mass on a spring: x = x0 cos(sqrt(k/m) t), with tolerances of k and x0."""

SPRING = """
format = 1
[parameters]
k = { value = "15 N/m", min = 1, max = 40, tol = 1 }
x0 = { value = "0.5 m", tol = 0.01 }
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.s]
type = "spring"
connect = ["ground.O", "block.P"]
stiffness = "k"
free_length = 0
[initial]
block = { x = "x0", vx = 0 }
"""
