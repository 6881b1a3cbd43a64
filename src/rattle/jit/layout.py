"""The columns of the arrays of a run, by name: `m.body[i, at.COS]`, with `from rattle.jit import layout as at`.

Each array with columns has a block below: name, unit and meaning of every column in order, one per line.  It is
followed by the numbers that code uses; a test compares the two.  Letters are those of the kernels.
"""

from __future__ import annotations

import re
from typing import NamedTuple


class Column(NamedTuple):
    """One column of an array."""

    unit: str
    meaning: str


COLUMNS: dict[str, dict[str, Column]] = {}  # array -> name -> unit and meaning, in order


def _declare(array: str, text: str) -> None:
    """Enter the columns of an array from lines "NAME [unit] meaning"."""
    found = (re.fullmatch(r"\s*(\w+) \[(.*?)\] (.+)", line) for line in text.strip().splitlines())
    COLUMNS[array] = {one[1]: Column(one[2], one[3]) for one in found if one}


def width(array: str) -> int:
    """Number of columns of an array."""
    return len(COLUMNS[array])


# fmt: off
# ---------------------------------------------------------------- the mechanism
_declare("body", """
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
_declare("rows", """
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
_declare("row_body", """
    ROW_A [] body A of the row
    ROW_B [] body B
""")
ROW_A, ROW_B = range(2)
_declare("pairs", """
    PAIR_ENTRY [] entry of `schur`
    PAIR_ROW [] row
    PAIR_COLUMN [] its first column for the body
    OTHER_ROW [] other row
    OTHER_COLUMN [] its first column for the body
    PAIR_BODY [] the body that they share
""")
PAIR_ENTRY, PAIR_ROW, PAIR_COLUMN, OTHER_ROW, OTHER_COLUMN, PAIR_BODY = range(6)
_declare("energy", """
    POTENTIAL [J] energy stored by the load
    ELASTIC [W] power of its elastic part
    OUTSIDE [W] power from outside
    DISSIPATED [W] power lost
""")
POTENTIAL, ELASTIC, OUTSIDE, DISSIPATED = range(4)
_declare("power", """
    POTENTIAL_ENERGY [J] of gravity and loads
    WORK_RATE [W] power of loads from outside
    LOSS_RATE [W] power dissipated by loads
    PIVOT_SHARE [] least pivot / its diagonal since it was set to 1
""")
POTENTIAL_ENERGY, WORK_RATE, LOSS_RATE, PIVOT_SHARE = range(4)
_declare("joint", """
    KERNEL [] number of its kernel; -1: only contacts act on it
    END_A [] body A
    END_B [] body B
    FIRST_P [] index of its first parameter in `values`
    FIRST_ROW [] its first constraint row
""")
KERNEL, END_A, END_B, FIRST_P, FIRST_ROW = range(5)
_declare("load", """
    KERNEL [] number of its kernel
    END_A [] body A
    END_B [] body B
    FIRST_P [] index of its first parameter in `values`
    CHANGES [] 1 if its values change during the run
""")
CHANGES = 4
_declare("contact", """
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
""")
SHAPE, A_BODY, B_BODY, SHAPE_P, CORNER, STATIC, STATIC_P, NORMAL_LAW, NORMAL_P, FRICTION, FRICTION_P = range(11)
OWNER, IMPACT, FIRST_STATE, STATES, FORCE_COLUMN, SENSE, LEVEL, TOOTHED = range(11, 19)
_declare("lever", """
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
_declare("signal", """
    FIRST_CODE [] first row of its program in `code`
    END_CODE [] row after the last one
    TARGET [] where its value goes: place in `signals`, `values` or `element_rate`
""")
for _other in ("jet", "jet_signal", "live", "state_rate"):
    COLUMNS[_other] = COLUMNS["signal"]
FIRST_CODE, END_CODE, TARGET = range(3)
_declare("switch", """
    FIRST_CODE [] first row of the program of its operands in `code`
    END_CODE [] row after the last one
    OWN_CODE [] row of the switch itself
    OPERANDS [] number of operands of the switching function, 1 or 2
""")
OWN_CODE, OPERANDS = 2, 3

# ---------------------------------------------------------------- contacts
_declare("contact_kinematics", """
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
""")
GAP, DGAP, NX, NY, PAX, PAY, PBX, PBY, SLIP, GAMMA_N, GAMMA_T, NORMAL, TANGENT, LOSS, STORE, ACROSS, TURN = range(17)
_declare("contact_memory", """
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
    ROUNDING [m/s] velocity scale before the last impact, relative to which rounding is judged
    RATE_BEFORE [m/s] rate of the gap before an impact
    SLIP_BEFORE [m/s] slip before an impact
    HITS [] Moreau-Jean: 1 for an impact in this step
    E_T [] its tangential restitution
    RATE_AFTER [m/s] rate of the gap with which a bounce leaves
    SHIFT [m] error by which its gap is too small
    STEPS_ON [] pressed steps in a row, or free ones with a negative sign
    SLIPS [] 1 for a clutch that slips at its largest torque
    SLIPPED [] the same before the present event
""")
CLOSED, SPEED, SINCE, PEAK, IMPULSE_0, LOSS_0, STEPS_IN, GAP_0, DGAP_0, N_0, GAP_1, DGAP_1, N_1 = range(13)
BOUNCES_END, ROUNDING, RATE_BEFORE, SLIP_BEFORE, HITS, E_T, RATE_AFTER, SHIFT, STEPS_ON, SLIPS, SLIPPED = range(13, 24)
OPEN, SHUT, AUTO = 0.0, 1.0, 2.0  # AUTO: in contact whenever there is penetration (statics)
_declare("recent", """
    LAST_IMPACT [s] instant of the last impact of a contact
    IMPACT_BEFORE [s] of the one before
""")
LAST_IMPACT, IMPACT_BEFORE = range(2)
_declare("held", """
    DETERMINANT [] sign of the determinant of the contact problem of the motion
    SIZE [m] typical length of the mechanism
    SPARSE [] 1 while G is sparse
    OUTCOME [] how the last search ended
    RIDGE [] share by which the diagonal of G is raised
    SCALE [] magnitude of the terms of the last a = G f + b
    WEAKEST [] smallest pivot / its diagonal, sparse solution
    SHARED [] 1 + a contact whose force may differ without changing the motion
""")
DETERMINANT, SIZE, SPARSE, OUTCOME, RIDGE, SCALE, WEAKEST, SHARED = range(8)
_declare("stuck", """
    EVENT_AT [s] time of the last event
    EVENTS_THERE [] events at that time so far
    EVENT_WHO [] contact of the last event
    EVENTS_IN_A_ROW [] events, each soon after the one before
""")
EVENT_AT, EVENTS_THERE, EVENT_WHO, EVENTS_IN_A_ROW = range(4)

LOOK_SHARE = 0  # of `looks` and `glances`: share of the step; then four indicators of every contact, the largest force

# ---------------------------------------------------------------- dry friction of joints without play
_declare("dry", """
    DRY_JOINT [] number of its joint
    DRY_A [] body A
    DRY_B [] body B
    DRY_KERNEL [] kernel of the row of its free coordinate
    DRY_P [] first parameter of that row in `values`
    DRY_ROW [] first row of the joint
    DRY_FORM [] DRY_PIN or DRY_GUIDE: how the normal force follows from its multipliers
    DRY_LAW [] kernel of its friction law; -1: set-valued
    DRY_STATE [] first state of that law among those of all elements
    DRY_STATES [] number of states of that law
""")
DRY_JOINT, DRY_A, DRY_B, DRY_KERNEL, DRY_P, DRY_ROW, DRY_FORM, DRY_LAW, DRY_STATE, DRY_STATES = range(10)
DRY_PIN, DRY_GUIDE = 0, 1
# parameters after those of the row (two points, a direction or zero, a function that is zero): arm [m or 1], 1/a [1/m];
# then mu and mu_static, or those of the law
DRY_ARM, DRY_REACH, DRY_MU, DRY_MU_STATIC = range(8, 12)
DRY_FIELDS = DRY_MU
_declare("dry_memory", """
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
""")
DRY_MODE, DRY_FORCE, DRY_RATE, DRY_HELD, DRY_OVER, DRY_LOCKS, DRY_REST, DRY_BEFORE, DRY_ADDED, DRY_SINCE = range(10)
DRY_STICKS, DRY_AUTO = 0.0, 2.0  # AUTO: the rate decides at every instant (positions, kinematics)

# ---------------------------------------------------------------- a run
_declare("clock", """
    T [s] time of `state`
    H [s] next step
    H_MIN [s] smallest step
    TROUBLE [s] time at which a step failed
    H_SOUND [s] last step with large pivots
    H_FREE [s] step of free flight
    FEWEST [] fewest steps in a contact
    CHANGE_AT [] share of the step at which a contact starts or ends
    H_STABLE [s] longest step at which the method is stable
    SHORTENED [] 1 if the last step was repeated because it was longer
""")
T, H, H_MIN, TROUBLE, H_SOUND, H_FREE, FEWEST, CHANGE_AT, H_STABLE, SHORTENED = range(10)
_declare("tally", """
    STEPS [] steps taken
    REJECTED [] steps repeated with a shorter length
    EVALUATIONS [] of the right-hand side, besides those for outputs
    OUTPUTS [] output rows written
    FOUND [] zero crossings waiting to be collected
    DRIFT_ROW [] row with the largest residual
    LOST_ROWS [] redundant rows
    LEAPS [] steps across singular positions
    STREAK [] attempts at one
    EVENT_COUNT [] events waiting to be collected
    CONTACTS [] contacts that started
    TAME [] 1 while stages are projected onto the constraints
    SERIES [] infinite series of bounces that were ended
""")
STEPS, REJECTED, EVALUATIONS, OUTPUTS, FOUND, DRIFT_ROW, LOST_ROWS, LEAPS, STREAK, EVENT_COUNT = range(10)
CONTACTS, TAME, SERIES = range(10, 13)
_declare("iteration", """
    JACOBIAN_T [s] time of the state at which the Jacobian was taken
    STALE [] 1 if there is none, or if the iteration with it was slow
    FACTORED_H [s] step for which its matrices are factored; 0: none
    KEPT_T [s] start of the step whose stages are kept
    KEPT_H [s] its length; 0: none is kept
    ROUNDS [] iterations for the stages of the last step
    CONTRACTION [] ratio of the last two corrections
    FAILED [] 1 if the last attempt found no stages
""")
JACOBIAN_T, STALE, FACTORED_H, KEPT_T, KEPT_H, ROUNDS, CONTRACTION, FAILED = range(8)
_declare("audit", """
    OPEN_LIMIT [] openness beyond which a step is rejected
    UNREST_LIMIT [] share of the turnover beyond which unrest rejects a step
    FLOOR [J] energy below which unrest is rounding
    STARTED [] 1 once the energies of the start are known
    TOTAL_0 [J] all energy at the start
    WORK_0 [J] work done at the start
    MOST_KINETIC [J] largest kinetic energy so far
    MOST_WORK [J] largest work so far
    LEAST_POTENTIAL [J] smallest potential energy so far
    MOST_POTENTIAL [J] largest so far
    MOST_UNREST [] largest unrest so far
    OPEN_ANGLE [rad] largest angle by which joints were open
    OPEN_LENGTH [m] largest length
    OPENNESS [] of the present step: largest residual, relative to the mechanism's size or 1 rad
    OPEN_ROW [] the row with that residual
    UNREST [] of the present step: energy error as a share of the turnover
    CORRECTION [] openness that was corrected in the present step
    SUNK [] largest depth of a set-valued contact in its wall, as a share of GAP_SCALE, Moreau-Jean only
""")
OPEN_LIMIT, UNREST_LIMIT, FLOOR, STARTED, TOTAL_0, WORK_0, MOST_KINETIC, MOST_WORK, LEAST_POTENTIAL = range(9)
MOST_POTENTIAL, MOST_UNREST, OPEN_ANGLE, OPEN_LENGTH, OPENNESS, OPEN_ROW, UNREST, CORRECTION, SUNK = range(9, 18)
_declare("landing", """
    LANDS [] 1 + switch at which the step ends; 0: none
    GO_ON [s] next step
    TURNS [] switchings so far
    LAST_TURN [s] time of the last one
    AGAIN [] switchings without progress in time
""")
LANDS, GO_ON, TURNS, LAST_TURN, AGAIN = range(5)
_declare("crossings", """
    CROSSING_T [s] instant
    CROSSING_FORCE [] number of the monitored force
    CROSSING_SIGN [] its new sign
""")
CROSSING_T, CROSSING_FORCE, CROSSING_SIGN = range(3)
_declare("events", """
    EVENT_T [s] instant
    EVENT_CONTACT [] number of the contact
    EVENT_KIND [] kind of event
    EVENT_SPEED [m/s or rad/s] along the normal
    EVENT_DURATION [s] of a contact that has ended
    EVENT_PEAK [N or N*m] its largest force
    EVENT_IMPULSE [N*s or N*m*s] impulse
    EVENT_LOSS [J] energy lost
""")
EVENT_T, EVENT_CONTACT, EVENT_KIND, EVENT_SPEED, EVENT_DURATION, EVENT_PEAK, EVENT_IMPULSE, EVENT_LOSS = range(8)
CONTACT_EVENT, RELEASE_EVENT, IMPACT_EVENT, STICK_EVENT, SLIP_EVENT = 0.0, 1.0, 2.0, 3.0, 4.0
_declare("quantity", """
    FORM [] how it is formed from its columns: OF_VECTOR, OF_SIZE, OF_VALUE, OF_NEGATIVE or OF_LARGER
    FIRST_COLUMN [] its first column after those of bodies
""")
FORM, FIRST_COLUMN = range(2)
# length of a vector, magnitude, the number, its negative, the larger of two
OF_VECTOR, OF_SIZE, OF_VALUE, OF_NEGATIVE, OF_LARGER = range(5)

# ---------------------------------------------------------------- output rows
# the columns of every body, then of every joint and driver, the signals, the energies; names as in a result, with units
OUTPUT_BODY = {
    "x": "m", "y": "m", "angle": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s",
    "ax": "m/s^2", "ay": "m/s^2", "alpha": "rad/s^2",
}
# force on B, its moment about the joint's point on B, offset of that point from the one on A; minus the multiplier of
# the first row, work rate of the rows; N, T and penetration of the contacts of a clearance; force or moment of its
# stops on B
OUTPUT_JOINT = {
    "fx": "N", "fy": "N", "moment": "N*m", "ex": "m", "ey": "m", "effort": "N or N*m", "power": "W",
    "normal": "N", "tangential": "N", "penetration": "m", "stop": "N or N*m",
}
OUTPUT_ENERGY = {"kinetic": "J", "potential": "J", "work": "J", "dissipated": "J"}
PER_BODY, PER_JOINT, ENERGIES = len(OUTPUT_BODY), len(OUTPUT_JOINT), len(OUTPUT_ENERGY)
PLACE, RATE, RATE_RATE = 0, 3, 6  # of a body: first of x, y, angle, of their rates and of their accelerations
FX, FY, MOMENT, EX, EY, EFFORT, POWER, JOINT_NORMAL, JOINT_TANGENT, PENETRATION, STOP = range(PER_JOINT)
KINETIC, STORED, WORK, LOST = range(ENERGIES)
# rows of runs that are asked for powers go on with ports, of every joint and driver, then of every load: generalised
# force (force [N], moment about the mass centre [N*m]) on A, then on B; power from outside, lost, and stored [W]
PORT_A, PORT_B, SUPPLIED, WASTED, KEPT, PER_PORT = 0, 3, 6, 7, 8, 9
_declare("port_work", """
    A_IN [J] energy given to A by impulses so far
    A_OUT [J] energy taken from A
    B_IN [J] energy given to B
    B_OUT [J] energy taken from B
    A_NOW [J] energy given to A by the present impulse, scratch
    B_NOW [J] the same of B
""")
A_IN, A_OUT, B_IN, B_OUT, A_NOW, B_NOW = range(6)
