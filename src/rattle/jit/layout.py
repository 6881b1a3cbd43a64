"""The columns of the arrays of a run, by name: `m.body[i, at.COS]`, with `from rattle.jit import layout as at`.

Each array with columns has a block here or in `run_layout`, whose names are names of this module too: name, unit and
meaning of every column in order, one per line.  It is followed by the numbers that code uses; a test compares the two.
Letters are those of the kernels.
"""

from __future__ import annotations

from rattle.jit.columns import COLUMNS, declare
from rattle.jit.columns import Column as Column
from rattle.jit.columns import width as width
from rattle.jit.run_layout import *  # noqa: F403

# fmt: off
# ---------------------------------------------------------------- the mechanism
declare("body", """
    X [m] mass centre
    Y [m] mass centre
    PHI [rad] angle
    VX [m/s] rate of x
    VY [m/s] rate of y
    W [rad/s] rate of the angle
    COS [] cosine of the angle
    SIN [] sine of the angle
""")
X, Y, PHI, VX, VY, W, COS, SIN = range(8)
declare("rows", """
    RES [m or rad] residual Phi
    NU [m/s or rad/s] right-hand side of Phi_q v = nu
    GAMMA [m/s^2 or rad/s^2] right-hand side of Phi_q dv = gamma
    AX [1 or 1/m] Jacobian with respect to x of A
    AY [1 or 1/m] with respect to y of A
    AP [m or 1] with respect to the angle of A
    BX [1 or 1/m] with respect to x of B
    BY [1 or 1/m] with respect to y of B
    BP [m or 1] with respect to the angle of B
""")
RES, NU, GAMMA, AX, AY, AP, BX, BY, BP = range(9)
declare("row_body", """
    ROW_A [] body A of the row
    ROW_B [] body B
""")
ROW_A, ROW_B = range(2)
declare("pairs", """
    PAIR_ENTRY [] entry of `schur`
    PAIR_ROW [] row
    PAIR_COLUMN [] its first column for the body
    OTHER_ROW [] other row
    OTHER_COLUMN [] its first column for the body
    PAIR_BODY [] the body that they share
""")
PAIR_ENTRY, PAIR_ROW, PAIR_COLUMN, OTHER_ROW, OTHER_COLUMN, PAIR_BODY = range(6)
declare("energy", """
    POTENTIAL [J] energy stored by the load
    ELASTIC [W] power of its elastic part
    OUTSIDE [W] power from outside
    DISSIPATED [W] power lost
""")
POTENTIAL, ELASTIC, OUTSIDE, DISSIPATED = range(4)
declare("power", """
    POTENTIAL_ENERGY [J] of gravity and loads
    WORK_RATE [W] power of loads from outside
    LOSS_RATE [W] power dissipated by loads
    PIVOT_SHARE [] least pivot / its diagonal since it was set to 1
""")
POTENTIAL_ENERGY, WORK_RATE, LOSS_RATE, PIVOT_SHARE = range(4)
declare("pivots_of_row", """
    SHARE_NOW [] pivot / its diagonal, as factored last; 0 if the row is redundant
    SHARE_LEAST [] smallest so far in the present step
    SHARE_MOST [] largest
    SHARE_BEFORE [] at the start of the step
    SHARE_AFTER [] at its end
    MAY_VANISH [] 1 if the pivot may vanish inside the step
""")
SHARE_NOW, SHARE_LEAST, SHARE_MOST, SHARE_BEFORE, SHARE_AFTER, MAY_VANISH = range(6)
declare("joint", """
    KERNEL [] number of its kernel; -1: only contacts act on it
    END_A [] body A
    END_B [] body B
    FIRST_P [] index of its first parameter in `values`
    FIRST_ROW [] its first constraint row
""")
KERNEL, END_A, END_B, FIRST_P, FIRST_ROW = range(5)
declare("load", """
    KERNEL [] number of its kernel
    END_A [] body A
    END_B [] body B
    FIRST_P [] index of its first parameter in `values`
    CHANGES [] 1 if its values change during the run
""")
CHANGES = 4
declare("contact", """
    SHAPE [] kernel of its geometry
    A_BODY [] body A, which bears
    B_BODY [] body B
    SHAPE_P [] first parameter of its geometry
    CORNER [] which corner of a block
    STATIC [] kernel of the static force
    STATIC_P [] its first parameter
    NORMAL_LAW [] kernel of the normal force
    NORMAL_P [] its first parameter; of an impact contact the first of its fields
    FRICTION [] kernel of friction; -1: none
    FRICTION_P [] its first parameter
    OWNER [] number of its joint
    IMPACT [] 1 for a set-valued contact, 0 for a compliant one
    FIRST_STATE [] first state of its friction law among those of all elements
    STATES [] number of states of that law
    FORCE_COLUMN [] column of its joint in an output row to which N is added
    SENSE [] 1 or -1: N there counts positive or negative
    LEVEL [] 1 for a contact without gap that the rate g' alone decides, 0 otherwise
    TOOTHED [] 1 for a gap that becomes one pitch smaller where it reaches a pitch
    FILM_LAW [] kernel of the oil film in the clearance; -1: none
    FILM_P [] its first parameter
    WORN [] 1 for a pin and a bush with profiles of wear on an elastic foundation
""")
SHAPE, A_BODY, B_BODY, SHAPE_P, CORNER, STATIC, STATIC_P, NORMAL_LAW, NORMAL_P, FRICTION, FRICTION_P = range(11)
OWNER, IMPACT, FIRST_STATE, STATES, FORCE_COLUMN, SENSE, LEVEL, TOOTHED, FILM_LAW, FILM_P, WORN = range(11, 22)
declare("lever", """
    ARM_A [m] longest arm on A to its contact points
    ARM_B [m] longest arm on B
    WALLS_TURN [] 1 if straight walls turn with A, 2 if with B
    ROUNDED [] 1 if a wall is curved
    ANGULAR [] 1 if the gap is an angle, N a moment
    GAP_SCALE [m or rad] size of the gap by which tolerances are set: the clearance, the range between two stops
    GAP_SIZE [m or rad] typical length of the mechanism, or 1 rad
    SLOPE [m] largest derivative of the gap by the angles of the bodies, besides that of arms and turning walls
    CURVE [m] largest second derivative by the angle of B to A
    BOW [1/m] largest second derivative by the offset of the points
""")
ARM_A, ARM_B, WALLS_TURN, ROUNDED, ANGULAR, GAP_SCALE, GAP_SIZE, SLOPE, CURVE, BOW = range(10)
# parameters of a joint, driver or load between two points start with these (x, y each); those of contacts go on with
# the clearance, the radius of the bush, the fields of the joint and its dimensions
POINTS = 4
CLEARANCE, RADIUS, FIELDS = 4, 5, 6
# parameters of a set-valued contact: the fields of `impact` in their order
RESTITUTION, TANGENTIAL_RESTITUTION, MU, RESTITUTION_LAW, JAM = range(5)
# those of a clutch go on with these: largest torque [N*m], stiffness [N*m/rad], damping [N*m*s/rad]
MOST_TORQUE, WIND_UP, OIL = range(5, 8)
# parameters of the geometry of a ratchet after the points and the sense: pitch [rad] and k, which changes in a run
PITCH, TOOTH = POINTS + 1, POINTS + 2
declare("signal", """
    FIRST_CODE [] first row of its program in `code`
    END_CODE [] row after the last one
    TARGET [] where its value goes: place in `signals`, `values` or `element_rate`
""")
for _other in ("jet", "jet_signal", "live", "state_rate"):
    COLUMNS[_other] = COLUMNS["signal"]
FIRST_CODE, END_CODE, TARGET = range(3)
declare("switch", """
    FIRST_CODE [] first row of the program of its operands in `code`
    END_CODE [] row after the last one
    OWN_CODE [] row of the switch itself
    OPERANDS [] number of operands of the switching function, 1 or 2
""")
OWN_CODE, OPERANDS = 2, 3

# ---------------------------------------------------------------- contacts
declare("contact_kinematics", """
    GAP [m or rad] gap g; negative: penetration
    DGAP [m/s or rad/s] its rate
    NX [] normal n from A outwards; the force on B is -N n - T t, t = n turned by 90 degrees
    NY [] the same along y
    PAX [m] arm of the contact point from the mass centre of A
    PAY [m] the same along y
    PBX [m] arm from the mass centre of B
    PBY [m] the same along y
    SLIP [m/s] u . t of B's material against A's
    GAMMA_N [m/s^2 or rad/s^2] gamma of the normal row
    GAMMA_T [m/s^2] gamma of the tangential row
    NORMAL [N or N*m] N
    TANGENT [N] T
    LOSS [W] power taken from the motion and lost
    STORE [W] power taken from the motion and stored
    ACROSS [m/s] speed of a pin's centre along t
    TURN [] couple of the normal: the moment on B is -N TURN besides that of the force; alone (n = 0) for an angular gap
    FILM_X [N] force of the oil film on B at its point
    FILM_Y [N] the same along y
    FILM_A [N*m] its moment on A about the point of A; the force on A is the opposite one, there
    FILM_B [N*m] its moment on B about the point of B
    FILM_LOSS [W] what it loses
""")
GAP, DGAP, NX, NY, PAX, PAY, PBX, PBY, SLIP, GAMMA_N, GAMMA_T, NORMAL, TANGENT, LOSS, STORE, ACROSS, TURN = range(17)
FILM_X, FILM_Y, FILM_A, FILM_B, FILM_LOSS = range(17, 22)
declare("contact_memory", """
    CLOSED [] OPEN, SHUT or AUTO
    SPEED [m/s or rad/s] approach speed
    SINCE [s] start of the contact
    PEAK [N or N*m] largest N so far
    IMPULSE_0 [N*s or N*m*s] impulse at its start
    LOSS_0 [J] energy lost at its start
    STEPS_IN [] steps so far in a compliant contact
    GAP_0 [m or rad] gap at the start of the step
    DGAP_0 [m/s or rad/s] its rate there
    N_0 [N or N*m] N there
    GAP_1 [m or rad] gap at the end of the step
    DGAP_1 [m/s or rad/s] its rate there
    N_1 [N or N*m] N there
    BOUNCES_END [s] end of a series of bounces that is not followed further; 0: none
    ROUNDING [m/s] size of the rates before the last impact and of what its impulses change: share of it is rounding
    RATE_BEFORE [m/s] rate of the gap before an impact
    SLIP_BEFORE [m/s] slip before an impact
    HITS [] Moreau-Jean: 1 for an impact in this step
    E_T [] its tangential restitution
    RATE_AFTER [m/s] rate of the gap with which a bounce leaves
    SHIFT [m] error by which its gap is too small
    STEPS_ON [] pressed steps in a row, or free ones with a negative sign
    SLIPS [] 1 for a clutch that slips at its largest torque
    SLIPPED [] the same before the present event
    IDLE [] 1 for a contact at rest without a force: joints or other contacts hold it, whatever its force
    UNSURE [] 1 once its force could have been another with the same motion
""")
CLOSED, SPEED, SINCE, PEAK, IMPULSE_0, LOSS_0, STEPS_IN, GAP_0, DGAP_0, N_0, GAP_1, DGAP_1, N_1 = range(13)
BOUNCES_END, ROUNDING, RATE_BEFORE, SLIP_BEFORE, HITS, E_T, RATE_AFTER, SHIFT, STEPS_ON, SLIPS, SLIPPED = range(13, 24)
IDLE, UNSURE = range(24, 26)
OPEN, SHUT, AUTO = 0.0, 1.0, 2.0  # AUTO: in contact whenever there is penetration (statics)
declare("recent", """
    LAST_IMPACT [s] instant of the last impact of a contact
    IMPACT_BEFORE [s] of the one before
""")
LAST_IMPACT, IMPACT_BEFORE = range(2)
declare("held", """
    DETERMINANT [] sign of the determinant of the contact problem of the motion
    SIZE [m] typical length of the mechanism
    SPARSE [] 1 while G is sparse
    OUTCOME [] how the last search ended
    RIDGE [] share by which the diagonal of G is raised
    SCALE [] magnitude of the terms of the last a = G f + b
    WEAKEST [] smallest pivot / its diagonal, sparse solution
    NOISE [1/kg] of entries of G
    LOCK_SHARE [] smallest (G_nn +- mu G_nt) / G_nn of a sliding contact so far: it locks if it is <= 0
    LOCK_AT [s] when
    LOCK_CONTACT [] which contact
    FAINT [SI] magnitude below which a is rounding, whatever f
""")
DETERMINANT, SIZE, SPARSE, OUTCOME, RIDGE, SCALE, WEAKEST, NOISE, LOCK_SHARE, LOCK_AT, LOCK_CONTACT, FAINT = range(12)
declare("stuck", """
    EVENT_AT [s] time of the last event
    EVENTS_THERE [] events at that time so far
    EVENT_WHO [] contact of the last event
    EVENTS_IN_A_ROW [] events, each soon after the one before
""")
EVENT_AT, EVENTS_THERE, EVENT_WHO, EVENTS_IN_A_ROW = range(4)

LOOK_SHARE = 0  # of `looks` and `glances`: share of the step; then four indicators of every contact, the largest force

# ---------------------------------------------------------------- dry friction of joints without play
declare("dry", """
    DRY_JOINT [] number of its joint
    DRY_A [] body A
    DRY_B [] body B
    DRY_KERNEL [] kernel of the row of its free coordinate
    DRY_P [] first parameter of that row in `values`
    DRY_ROW [] first row of the joint
    DRY_FORM [] DRY_PIN, DRY_GUIDE, DRY_SURFACE or DRY_ROD: how the normal force follows from its multipliers
    DRY_LAW [] kernel of its friction law; -1: set-valued
    DRY_STATE [] first state of that law among those of all elements
    DRY_STATES [] number of states of that law
    DRY_SECOND [] second row of the joint; the first again, where there is one only; of DRY_ROD: entry of its other pin
    DRY_COLUMN [] column of an output row of the joint, for tau
""")
DRY_JOINT, DRY_A, DRY_B, DRY_KERNEL, DRY_P, DRY_ROW, DRY_FORM, DRY_LAW, DRY_STATE, DRY_STATES, DRY_SECOND = range(11)
DRY_COLUMN = 11
DRY_PIN, DRY_GUIDE, DRY_SURFACE, DRY_ROD = 0, 1, 2, 3
# parameters after those of the row (two points, a direction or zero, a function that is zero): arm [m or 1], 1/a [1/m];
# then mu and mu_static, or those of the law
DRY_ARM, DRY_REACH, DRY_MU, DRY_MU_STATIC = range(8, 12)
DRY_FIELDS = DRY_MU
declare("dry_memory", """
    DRY_MODE [] sense of slip 1 or -1, DRY_STICKS or DRY_AUTO
    DRY_FORCE [N or N*m] tau along the free coordinate
    DRY_RATE [m/s or rad/s] rate of that coordinate
    DRY_HELD [] 1 if other joints and drivers hold the coordinate
    DRY_OVER [] 1 if the mode could not last at an instant since it was set to 0
    DRY_LOCKS [] 1 if no tau was found
    DRY_REST [] 1 while its mode is being decided at rest
    DRY_BEFORE [] its mode before that
    DRY_ADDED [N or N*m] part of tau that accelerations and multipliers contain
    DRY_SINCE [s] instant at which it has begun to slip from rest
    DRY_UNSURE [] 1 once its force could have been another with the same motion
    IMPACT_MODE [] mode in an impact, see `rubbing_impacts`
    IMPACT_ALONE [N*s or N*m*s] part of its impulse that those of contacts do not cause
    IMPACT_FRICTION [N*s or N*m*s] its impulse
    DRY_SOUGHT [] 1 while the instant is sought from which its mode cannot last
    DRY_PRESSED [] 1 while closed contacts hold its coordinate at rest, against whatever friction does
""")
DRY_MODE, DRY_FORCE, DRY_RATE, DRY_HELD, DRY_OVER, DRY_LOCKS, DRY_REST, DRY_BEFORE, DRY_ADDED, DRY_SINCE = range(10)
DRY_UNSURE, IMPACT_MODE, IMPACT_ALONE, IMPACT_FRICTION, DRY_SOUGHT, DRY_PRESSED = range(10, 16)
DRY_STICKS, DRY_AUTO = 0.0, 2.0  # AUTO: the rate decides at every instant (positions, kinematics)
