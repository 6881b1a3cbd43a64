"""Contacts of clutches: couples between two bodies, at velocity level or from tooth to tooth.

The parameters of a kernel are, in this order: the points of A and B (x, y each) [m], which are not used, the sense (1
or -1), and what the kind adds.
"""

from rattle.jit import layout as at

SENSE = at.POINTS  # place of the sense among the parameters
