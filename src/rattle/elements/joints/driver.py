"""Drivers: a joint's degree of freedom follows a given function of time f(t).

    angle:    Phi = phi_B - phi_A - f = 0                                                    [rad]
              nu  = f',  gamma = f''
    position: Phi = u . d - f = 0   (u: line of the prismatic joint, n = u turned by 90 deg) [m]
              nu  = f'
              gamma = f'' + u . (s_B w_B^2 - s_A w_A^2) - 2 w_A (n . d') + w_A^2 (u . d)
    body x, y: Phi = i . (r_B + s_B) - f = 0   (i: unit vector of the ground)                [m]
              nu = f',  gamma = f'' + i . s_B w_B^2
    body angle: as angle, A the ground                                                       [rad]

    speed:    as angle or position, with f = c + X, X' = s(t), X = 0 at t = 0; f' = s, f'' = s'

Parameters: the two points [m], the direction of the joint's line in A [rad] if it has one, for a speed s the constant c
[rad or m] with which the row vanishes at the start, then f, f', f'' (X, s, s'), which are evaluated before the rows:
X is a state of the run, all others are exact.
"""

from __future__ import annotations

from rattle.interfaces.joints import DriverKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import angle_row, position_row, turn_x, turn_y
from rattle.registry import Field, kind


@kernel("joint")
def driver_angle(body, a, b, p, k, row, rows):
    """Write the row of a driven angle [rad]; p[k + 4:] = f, f', f''."""
    angle_row(body, a, b, p[k + 4], p[k + 5], p[k + 6], row, rows)


@kernel("joint")
def driver_position(body, a, b, p, k, row, rows):
    """Write the row of a driven position [m]; p[k + 4:] = direction of the line [rad], f, f', f''."""
    position_row(body, a, b, p, k, p[k + 4], p[k + 5], p[k + 6], p[k + 7], row, rows)


@kernel("joint")
def driver_angle_speed(body, a, b, p, k, row, rows):
    """Write the row of an angle driven at a speed [rad]; p[k + 4:] = c, X, s, s'."""
    angle_row(body, a, b, p[k + 4] + p[k + 5], p[k + 6], p[k + 7], row, rows)


@kernel("joint")
def driver_position_speed(body, a, b, p, k, row, rows):
    """Write the row of a position driven at a speed [m]; p[k + 4:] = direction of the line [rad], c, X, s, s'."""
    position_row(body, a, b, p, k, p[k + 4], p[k + 5] + p[k + 6], p[k + 7], p[k + 8], row, rows)


@kernel("joint")
def driver_x(body, a, b, p, k, row, rows):
    """Write the row of a driven x coordinate of a body [m]; p[k + 4:] = f, f', f''."""
    sbx = turn_x(body, b, p[k + 2], p[k + 3])
    sby = turn_y(body, b, p[k + 2], p[k + 3])
    rows[row, at.RES] = body[b, at.X] + sbx - p[k + 4]
    rows[row, at.NU] = p[k + 5]
    rows[row, at.GAMMA] = p[k + 6] + sbx * body[b, at.W] * body[b, at.W]
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = 0.0, 0.0, 0.0
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = 1.0, 0.0, -sby


@kernel("joint")
def driver_y(body, a, b, p, k, row, rows):
    """Write the row of a driven y coordinate of a body [m]; p[k + 4:] = f, f', f''."""
    sbx = turn_x(body, b, p[k + 2], p[k + 3])
    sby = turn_y(body, b, p[k + 2], p[k + 3])
    rows[row, at.RES] = body[b, at.Y] + sby - p[k + 4]
    rows[row, at.NU] = p[k + 5]
    rows[row, at.GAMMA] = p[k + 6] + sby * body[b, at.W] * body[b, at.W]
    rows[row, at.AX], rows[row, at.AY], rows[row, at.AP] = 0.0, 0.0, 0.0
    rows[row, at.BX], rows[row, at.BY], rows[row, at.BP] = 0.0, 1.0, sbx


class Turning(DriverKind):
    """What the drivers of an angle share."""

    rows = ("rad",)
    sets_angle = True
    effort = ("torque", "N*m")


class Sliding(DriverKind):
    """What the drivers of a length share."""

    rows = ("m",)
    effort = ("force", "N")


@kind("driver", "angle", driver_angle)
class DriverAngle(Turning):
    """The angle phi_B - phi_A of a revolute joint follows a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "joint"
    angle = Field("rad", "angle of B relative to A as a function of t", live=True)


@kind("driver", "position", driver_position)
class DriverPosition(Sliding):
    """The position of a prismatic joint's point of B along the line follows a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "joint"
    along_line = True
    position = Field("m", "distance along the line from the point of A as a function of t", live=True)


@kind("driver", "body-x", driver_x)
class DriverBodyX(Sliding):
    """The x coordinate of a body's mass centre, or of a point of it, follows a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "body"
    position = Field("m", "coordinate in the ground frame as a function of t", live=True)


@kind("driver", "body-y", driver_y)
class DriverBodyY(Sliding):
    """The y coordinate of a body's mass centre, or of a point of it, follows a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "body"
    position = Field("m", "coordinate in the ground frame as a function of t", live=True)


@kind("driver", "body-angle", driver_angle)
class DriverBodyAngle(Turning):
    """The angle of a body follows a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "body"
    angle = Field("rad", "angle in the ground frame as a function of t", live=True)


@kind("driver", "angle-speed", driver_angle_speed)
class DriverAngleSpeed(Turning):
    """The angle of a revolute joint goes on from the start at a rate that is a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "joint"
    rate_of = "angle"
    from_start = 1
    speed = Field("rad/s", "rate of the angle of B relative to A as a function of t", live=True)


@kind("driver", "position-speed", driver_position_speed)
class DriverPositionSpeed(Sliding):
    """The position of a prismatic joint goes on from the start at a speed that is a function of time.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 3.5.
    """

    drives = "joint"
    rate_of = "position"
    from_start = 1
    along_line = True
    speed = Field("m/s", "speed along the line as a function of t", live=True)
