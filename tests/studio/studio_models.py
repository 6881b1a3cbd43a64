"""Models that tests of the studio share."""

PENDULUM = """# a pendulum; this comment stays
format = 1
name = "a pendulum"
gravity = [0, -9.81]

[parameters]
l = { value = "1 m", min = "0.2 m", max = "2 m" }    # length

[ground.points]
O = [0, 0]

[bodies.rod]
bar = ["A", "B"]
length = "l"
mass = 1

[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]

[simulate]
t_end = "1 s"
"""
