"""Stops: the ends of the coordinate of a joint, as contacts besides its rows.

A kind is named after the driver that moves the same coordinate.  The parameters of a kernel are, in this order: the
points of A and B (x, y each) [m], the least and the largest value of the coordinate [m or rad], the direction of the
joint's line in A [rad].  Contact 0 is at the least value and pushes B on, contact 1 at the largest pushes it back.
"""

from rattle.jit import layout as at

LEAST, LARGEST, LINE = at.POINTS, at.POINTS + 1, at.POINTS + 2  # places of the parameters after the points
