"""The columns of the arrays of a run, by name: `m.body[i, at.COS]`, with `from rattle.jit import layout as at`.

Each array with columns has a block here or in `run_layout`, whose names are names of this module too: name, unit and
meaning of every column in order, one per line.  Letters are those of the kernels.
"""

from __future__ import annotations

from rattle.jit.columns import COLUMNS as COLUMNS
from rattle.jit.columns import Column as Column
from rattle.jit.columns import column, name_columns, share
from rattle.jit.columns import width as width
from rattle.jit.run_layout import *  # noqa: F403  # its columns are named here as all others
from rattle.jit.run_layout import END_CODE, FIRST_CODE, OWN_CODE

# fmt: off
# ---------------------------------------------------------------- the mechanism
X = column("body", "m", "mass centre")
Y = column("body", "m", "mass centre")
PHI = column("body", "rad", "angle")
VX = column("body", "m/s", "rate of x")
VY = column("body", "m/s", "rate of y")
W = column("body", "rad/s", "rate of the angle")
COS = column("body", "", "cosine of the angle")
SIN = column("body", "", "sine of the angle")

RES = column("rows", "m or rad", "residual Phi")
NU = column("rows", "m/s or rad/s", "right-hand side of Phi_q v = nu")
GAMMA = column("rows", "m/s^2 or rad/s^2", "right-hand side of Phi_q dv = gamma")
AX = column("rows", "1 or 1/m", "Jacobian with respect to x of A")
AY = column("rows", "1 or 1/m", "with respect to y of A")
AP = column("rows", "m or 1", "with respect to the angle of A")
BX = column("rows", "1 or 1/m", "with respect to x of B")
BY = column("rows", "1 or 1/m", "with respect to y of B")
BP = column("rows", "m or 1", "with respect to the angle of B")

ROW_A = column("row_body", "", "body A of the row")
ROW_B = column("row_body", "", "body B")

PAIR_ENTRY = column("pairs", "", "entry of `schur`")
PAIR_ROW = column("pairs", "", "row")
PAIR_COLUMN = column("pairs", "", "its first column for the body")
OTHER_ROW = column("pairs", "", "other row")
OTHER_COLUMN = column("pairs", "", "its first column for the body")
PAIR_BODY = column("pairs", "", "the body that they share")

POTENTIAL = column("energy", "J", "energy stored by the load")
ELASTIC = column("energy", "W", "power of its elastic part")
OUTSIDE = column("energy", "W", "power from outside")
DISSIPATED = column("energy", "W", "power lost")

POTENTIAL_ENERGY = column("power", "J", "of gravity and loads")
WORK_RATE = column("power", "W", "power of loads from outside")
LOSS_RATE = column("power", "W", "power dissipated by loads")
CULLS = column("power", "", "1 while contacts that are far apart are left out, as within a step")
PIVOT_SHARE = column("power", "", "least pivot / its diagonal since it was set to 1")

SHARE_NOW = column("pivots_of_row", "", "pivot / its diagonal, as factored last; 0 if the row is redundant")
SHARE_LEAST = column("pivots_of_row", "", "smallest so far in the present step")
SHARE_MOST = column("pivots_of_row", "", "largest")
SHARE_BEFORE = column("pivots_of_row", "", "at the start of the step")
SHARE_AFTER = column("pivots_of_row", "", "at its end")
MAY_VANISH = column("pivots_of_row", "", "1 if the pivot may vanish inside the step")

KERNEL = column("joint", "", "number of its kernel; -1 of a joint: only contacts act on it")
END_A = column("joint", "", "body A")
END_B = column("joint", "", "body B")
FIRST_P = column("joint", "", "index of its first parameter in `values`")
FIRST_ROW = column("joint", "", "its first constraint row")

share("load", KERNEL, END_A, END_B, FIRST_P)
CHANGES = column("load", "", "1 if its values change during the run")

SHAPE = column("contact", "", "kernel of its geometry")
A_BODY = column("contact", "", "body A, which bears")
B_BODY = column("contact", "", "body B")
SHAPE_P = column("contact", "", "first parameter of its geometry")
CORNER = column("contact", "", "which corner of a block")
STATIC = column("contact", "", "kernel of the static force")
STATIC_P = column("contact", "", "its first parameter")
NORMAL_LAW = column("contact", "", "kernel of the normal force")
NORMAL_P = column("contact", "", "its first parameter; of an impact contact the first of its fields")
FRICTION = column("contact", "", "kernel of friction; -1: none")
FRICTION_P = column("contact", "", "its first parameter")
OWNER = column("contact", "", "number of its joint")
IMPACT = column("contact", "", "1 for a set-valued contact, 0 for a compliant one")
FIRST_STATE = column("contact", "", "first state of its friction law among those of all elements")
STATES = column("contact", "", "number of states of that law")
FORCE_COLUMN = column("contact", "", "column of its joint in an output row to which N is added")
SENSE = column("contact", "", "1 or -1: N there counts positive or negative")
LEVEL = column("contact", "", "1 for a contact without gap that the rate g' alone decides, 0 otherwise")
TOOTHED = column("contact", "", "1 for a gap that becomes one pitch smaller where it reaches a pitch")
FILM_LAW = column("contact", "", "kernel of the oil film in the clearance; -1: none")
FILM_P = column("contact", "", "its first parameter")
WORN = column("contact", "", "1 for a pin and a bush with profiles of wear on an elastic foundation")
OWN_COLUMN = column("contact", "", "number of the column of an output row that is its N alone; -1: none")
SPAN = column("contact", "", "number of contacts from this one on whose gaps its kernel bounds together; 0: none")
BY_FORCE = column("contact", "", "1 for a compliant contact that ends where its force does, 0: where its gap opens")
VANISHES = column("contact", "", "1 for a compliant contact whose force is 0 where its gap opens, and goes on beyond")

ARM_A = column("lever", "m", "longest arm on A to its contact points")
ARM_B = column("lever", "m", "longest arm on B")
WALLS_TURN = column("lever", "", "1 if straight walls turn with A, 2 if with B")
ROUNDED = column("lever", "", "1 if a wall is curved around B, 2 if B is outside of it, 0 if it is not curved")
ANGULAR = column("lever", "", "1 if the gap is an angle, N a moment")
ONE_WAY = column("lever", "", "1 if a contact bears on one side and ends at an end, see `equations.one_way`")
GAP_SCALE = column("lever", "m or rad",
    "size of the gap by which tolerances are set: the clearance, the range between two stops")
GAP_SIZE = column("lever", "m or rad", "typical length of the mechanism, or 1 rad")
SLOPE = column("lever", "m",
    "largest derivative of the gap by the angles of the bodies, besides that of arms and turning walls")
CURVE = column("lever", "m", "largest second derivative by the angle of B to A")
BOW = column("lever", "1/m", "largest second derivative by the offset of the points")
# parameters of a joint, driver or load between two points start with these (x, y each); those of contacts go on with
# the clearance, the radius of the bush, the fields of the joint and its dimensions
POINTS = 4
CLEARANCE, RADIUS, FIELDS = 4, 5, 6
# parameters of a set-valued contact: the fields of `impact` in their order
RESTITUTION, TANGENTIAL_RESTITUTION, MU, RESTITUTION_LAW, JAM, CHAIN_STIFFNESS, CHAIN_EXPONENT = range(7)
# those of a clutch go on with these: largest torque [N*m], stiffness [N*m/rad], damping [N*m*s/rad]
MOST_TORQUE, WIND_UP, OIL = range(7, 10)
# parameters of the geometry of a ratchet after the points and the sense: pitch [rad] and k, which changes in a run
PITCH, TOOTH = POINTS + 1, POINTS + 2
share("signal", FIRST_CODE, END_CODE)
TARGET = column("signal", "", "where its value goes: place in `signals`, `values` or `element_rate`")
for _other in ("jet", "jet_signal", "live", "state_rate", "falling"):
    share(_other, FIRST_CODE, END_CODE, TARGET)
TRAVEL = column("jet", "", "number of the state that is its integral, which counts then; -1: it counts itself")
share("switch", FIRST_CODE, END_CODE, OWN_CODE)
OPERANDS = column("switch", "", "number of operands of the switching function, 1 or 2")

# ---------------------------------------------------------------- contacts
GAP = column("contact_kinematics", "m or rad", "gap g; negative: penetration")
DGAP = column("contact_kinematics", "m/s or rad/s", "its rate")
NX = column("contact_kinematics", "",
    "normal n from A outwards; the force on B is -N n - T t, t = n turned by 90 degrees")
NY = column("contact_kinematics", "", "the same along y")
PAX = column("contact_kinematics", "m", "arm of the contact point from the mass centre of A")
PAY = column("contact_kinematics", "m", "the same along y")
PBX = column("contact_kinematics", "m", "arm from the mass centre of B")
PBY = column("contact_kinematics", "m", "the same along y")
SLIP = column("contact_kinematics", "m/s", "u . t of B's material against A's")
GAMMA_N = column("contact_kinematics", "m/s^2 or rad/s^2", "gamma of the normal row")
GAMMA_T = column("contact_kinematics", "m/s^2", "gamma of the tangential row")
NORMAL = column("contact_kinematics", "N or N*m", "N")
TANGENT = column("contact_kinematics", "N", "T")
LOSS = column("contact_kinematics", "W", "power taken from the motion and lost")
STORE = column("contact_kinematics", "W", "power taken from the motion and stored")
ACROSS = column("contact_kinematics", "m/s", "speed of a pin's centre along t")
TURN = column("contact_kinematics", "",
    "couple of the normal: the moment on B is -N TURN besides that of the force; alone (n = 0) for an angular gap")
PHASE = column("contact_kinematics", "",
    "of a corner over a segment, or an end at an edge: AWAKE, ASLEEP or HELD; no kernel of a kind changes it")
ABOVE = column("contact_kinematics", "m", "how far it is above the segment")
BEYOND = column("contact_kinematics", "m", "how far it is beyond the nearer end; negative: over the segment")
AWAKE, ASLEEP, HELD = 0.0, 1.0, 2.0
EDGE = column("contact_kinematics", "", "of an end and an outline: the edge of a chain that was nearest, -1: a corner")
FILM_X = column("contact_kinematics", "N", "force of the oil film on B at its point")
FILM_Y = column("contact_kinematics", "N", "the same along y")
FILM_A = column("contact_kinematics", "N*m",
    "its moment on A about the point of A; the force on A is the opposite one, there")
FILM_B = column("contact_kinematics", "N*m", "its moment on B about the point of B")
FILM_LOSS = column("contact_kinematics", "W", "what it loses")

CLOSED = column("contact_memory", "", "OPEN, SHUT, AUTO or RELEASED")
SPEED = column("contact_memory", "m/s or rad/s", "approach speed")
SINCE = column("contact_memory", "s", "start of the contact")
PEAK = column("contact_memory", "N or N*m", "largest N so far")
IMPULSE_0 = column("contact_memory", "N*s or N*m*s", "impulse at its start")
LOSS_0 = column("contact_memory", "J", "energy lost at its start")
STEPS_IN = column("contact_memory", "", "steps so far in a compliant contact")
GAP_0 = column("contact_memory", "m or rad", "gap at the start of the step")
DGAP_0 = column("contact_memory", "m/s or rad/s", "its rate there")
N_0 = column("contact_memory", "N or N*m", "N there")
GAP_1 = column("contact_memory", "m or rad", "gap at the end of the step")
DGAP_1 = column("contact_memory", "m/s or rad/s", "its rate there")
N_1 = column("contact_memory", "N or N*m", "N there")
BOUNCES_END = column("contact_memory", "s", "end of a series of bounces that is not followed further; 0: none")
ROUNDING = column("contact_memory", "m/s",
    "size of the rates before the last impact and of what its impulses change: share of it is rounding")
RATE_BEFORE = column("contact_memory", "m/s", "rate of the gap before an impact")
SLIP_BEFORE = column("contact_memory", "m/s", "slip before an impact")
HITS = column("contact_memory", "", "Moreau-Jean: 1 for an impact in this step")
E_T = column("contact_memory", "", "its tangential restitution")
RATE_AFTER = column("contact_memory", "m/s", "rate of the gap with which a bounce leaves")
SHIFT = column("contact_memory", "m", "error by which its gap is too small")
STEPS_ON = column("contact_memory", "", "pressed steps in a row, or free ones with a negative sign")
SLIPS = column("contact_memory", "", "1 for a clutch that slips at its largest torque")
SLIPPED = column("contact_memory", "", "the same before the present event")
IDLE = column("contact_memory", "",
    "1 for a contact at rest without a force: joints or other contacts hold it, whatever its force")
NO_SLIP = column("contact_memory", "",
    "1 for a contact with the friction of sliding that has no slip: other closed contacts hold it along its wall")
LEFT_END = column("contact_memory", "", "1 once its corner has left the end of its segment, or gone under it")
UNSURE = column("contact_memory", "",
    "1 once its force could have been another with the same motion, 2 with another motion")
OPEN, SHUT, AUTO = 0.0, 1.0, 2.0  # AUTO: in contact whenever there is penetration (statics)
RELEASED = 3.0  # inside the wall without force, once the damper of a contact would pull as its spring pushes
LAST_IMPACT = column("recent", "s", "instant of the last impact of a contact")
IMPACT_BEFORE = column("recent", "s", "of the one before")

DETERMINANT = column("held", "", "sign of the determinant of the contact problem of the motion")
SIZE = column("held", "m", "typical length of the mechanism")
SPARSE = column("held", "", "1 while G is sparse")
OUTCOME = column("held", "", "how the last search ended")
RIDGE = column("held", "", "share by which the diagonal of G is raised")
SCALE = column("held", "", "magnitude of the terms of the last a = G f + b")
WEAKEST = column("held", "", "smallest pivot / its diagonal, sparse solution")
NOISE = column("held", "1/kg", "of entries of G")
LOCK_SHARE = column("held", "", "smallest (G_nn +- mu G_nt) / G_nn of a sliding contact so far: it locks if it is <= 0")
LOCK_AT = column("held", "s", "when")
LOCK_CONTACT = column("held", "", "which contact")
FAINT = column("held", "SI", "magnitude below which a is rounding, whatever f")
BEFORE_JUMP = column("held", "", "share of the step just before an event that is a jump of a force; else 1")

EVENT_AT = column("stuck", "s", "time of the last event")
EVENTS_THERE = column("stuck", "", "events at that time so far")
EVENT_WHO = column("stuck", "", "contact of the last event")
EVENTS_IN_A_ROW = column("stuck", "", "events, each soon after the one before")

LOOK_SHARE = 0  # of `looks` and `glances`: share of the step; then four indicators of every contact, the largest force

# ---------------------------------------------------------------- dry friction of joints without play
DRY_JOINT = column("dry", "", "number of its joint")
DRY_A = column("dry", "", "body A")
DRY_B = column("dry", "", "body B")
DRY_KERNEL = column("dry", "", "kernel of the row of its free coordinate")
DRY_P = column("dry", "", "first parameter of that row in `values`")
DRY_ROW = column("dry", "", "first row of the joint")
DRY_FORM = column("dry", "",
    "DRY_PIN, DRY_GUIDE, DRY_SURFACE, DRY_ROD or DRY_ROLLER: how the normal force follows from its multipliers")
DRY_LAW = column("dry", "", "kernel of its friction law; -1: set-valued")
DRY_STATE = column("dry", "", "first state of that law among those of all elements")
DRY_STATES = column("dry", "", "number of states of that law")
DRY_SECOND = column("dry", "",
    "second row of the joint, or the first again; of DRY_ROD: entry of its other pin; of DRY_ROLLER: its contact")
DRY_COLUMN = column("dry", "", "column of an output row of the joint, for tau")
DRY_STATED = column("dry", "", "1: its size is stated: mu times the arm, whatever the joint bears")
DRY_PIN, DRY_GUIDE, DRY_SURFACE, DRY_ROD, DRY_ROLLER = 0, 1, 2, 3, 4
# parameters after those of the row (two points, a direction or zero, a function that is zero): arm [m or 1], 1/a [1/m];
# then mu and mu_static, or those of the law
DRY_ARM, DRY_REACH, DRY_MU, DRY_MU_STATIC = range(8, 12)
DRY_FIELDS = DRY_MU
DRY_MODE = column("dry_memory", "", "sense of slip 1 or -1, DRY_STICKS or DRY_AUTO")
DRY_FORCE = column("dry_memory", "N or N*m", "tau along the free coordinate")
DRY_RATE = column("dry_memory", "m/s or rad/s", "rate of that coordinate")
DRY_HELD = column("dry_memory", "", "1 if other joints and drivers hold the coordinate")
DRY_OVER = column("dry_memory", "", "1 if the mode could not last at an instant since it was set to 0")
DRY_LOCKS = column("dry_memory", "", "1 if no tau was found")
DRY_REST = column("dry_memory", "", "1 while its mode is being decided at rest")
DRY_BEFORE = column("dry_memory", "", "its mode before that")
DRY_ADDED = column("dry_memory", "N or N*m", "part of tau that accelerations and multipliers contain")
DRY_SINCE = column("dry_memory", "s", "instant at which it has begun to slip from rest")
DRY_UNSURE = column("dry_memory", "", "1 once its force could have been another with the same motion")
IMPACT_MODE = column("dry_memory", "", "mode in an impact, see `rubbing_impacts`")
IMPACT_ALONE = column("dry_memory", "N*s or N*m*s", "part of its impulse that those of contacts do not cause")
IMPACT_FRICTION = column("dry_memory", "N*s or N*m*s", "its impulse")
DRY_SOUGHT = column("dry_memory", "",
    "1 while the instant is sought from which its mode cannot last; then the sense of its force there")
DRY_PRESSED = column("dry_memory", "",
    "1 while closed contacts hold its coordinate at rest, against whatever friction does")
DRY_PRESS = column("dry_memory", "N", "of DRY_ROLLER: N of its contact, as far as it is known")
IMPACT_PRESS = column("dry_memory", "N*s", "the same in an impact")
DRY_FIRM = column("dry_memory", "", "1 while it rests at its limit, of mu_static, as others that stick hold it")
DRY_STICKS, DRY_AUTO = 0.0, 2.0  # AUTO: the rate decides at every instant (positions, kinematics)

name_columns(globals())
