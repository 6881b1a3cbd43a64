"""Columns of the arrays that a run carries from step to step and of what it writes; `layout` has their names too."""

from __future__ import annotations

from rattle.jit.columns import column

# fmt: off
# ---------------------------------------------------------------- a run
T = column("clock", "s", "time of `state`")
H = column("clock", "s", "next step")
H_MIN = column("clock", "s", "smallest step")
TROUBLE = column("clock", "s", "time at which a step failed")
H_SOUND = column("clock", "s", "last step with large pivots")
H_FREE = column("clock", "s", "step of free flight")
FEWEST = column("clock", "", "fewest steps in a contact")
CHANGE_AT = column("clock", "", "share of the step at which a contact starts or ends")
H_STABLE = column("clock", "s", "longest step at which the method is stable")
SHORTENED = column("clock", "", "1 if the last step was repeated because it was longer")
COLLAPSED = column("clock", "", "steps in a row that were far too short to get anywhere")

ADAPTIVE = column("stepper", "", "1 if its steps follow the tolerances")
ERROR_POWER = column("stepper", "", "power of the step with which the error of one step grows")
STAGES = column("stepper", "", "of a step")
SLOPES = column("stepper", "", "rows of `slopes` whose accelerations bound those in a step")
DENSE_STAGES = column("stepper", "", "further stages of its dense output")
STABLE = column("stepper", "", "step times fastest rate beyond which it is not stable; 0: not watched")

STEP = column("stepper_table", "", "takes a step")
DENSE = column("stepper_table", "", "completes its dense output")

STEPS = column("tally", "", "steps taken")
REJECTED = column("tally", "", "steps repeated with a shorter length")
EVALUATIONS = column("tally", "", "of the right-hand side, besides those for outputs")
OUTPUTS = column("tally", "", "output rows written")
FOUND = column("tally", "", "zero crossings waiting to be collected")
DRIFT_ROW = column("tally", "", "row with the largest residual")
LOST_ROWS = column("tally", "", "redundant rows")
LEAPS = column("tally", "", "steps across singular positions")
STREAK = column("tally", "", "attempts at one")
EVENT_COUNT = column("tally", "", "events waiting to be collected")
CONTACTS = column("tally", "", "contacts that started")
TAME = column("tally", "", "1 while stages are projected onto the constraints")
SERIES = column("tally", "", "infinite series of bounces that were ended")

ROOT_BEFORE = column("passage", "", "root of the least pivot share at the start of the step, see `singular_passage`")
ROOT_WITHIN = column("passage", "", "least one at its stages")
ROOT_AFTER = column("passage", "", "at its end")
TRIED_AT = column("passage", "s", "start of a step that was laid across a singular position")
USUAL_LOST = column("passage", "", "redundant rows at the start of the run")
ROOT_SLOPE = column("passage", "", "of the root over the step, next to the singular position")
PASSED_SHARE = column("passage", "", "share of the step at which it passes it")
ROOT_THERE = column("passage", "", "root there")
NEARBY = column("passage", "", "AWAY, BEFORE or PASSED of `singular_passage`")
PASSED = column("passage", "", "singular positions passed")
CLOSEST_ROOT = column("passage", "", "least root since it is not AWAY")
NEAR_SINCE = column("passage", "s", "time since when it is not AWAY")
SUSPECTS = column("passage", "", "rows whose pivot may vanish inside the step")

PASSED_AT = column("passages", "s", "instant")
PASSED_ROOT = column("passages", "", "root there")
PASSED_FROM = column("passages", "s", "from here on forces do not count")
PASSED_UNTIL = column("passages", "s", "until here")

JACOBIAN_T = column("iteration", "s", "time of the state at which the Jacobian was taken")
STALE = column("iteration", "", "1 if there is none, or if the iteration with it was slow")
FACTORED_H = column("iteration", "s", "step for which its matrices are factored; 0: none")
KEPT_T = column("iteration", "s", "start of the step whose stages are kept")
KEPT_H = column("iteration", "s", "its length; 0: none is kept")
ROUNDS = column("iteration", "", "iterations for the stages of the last step")
CONTRACTION = column("iteration", "", "ratio of the last two corrections")
FAILED = column("iteration", "", "1 if the last attempt found no stages")
JACOBIAN_H = column("iteration", "s", "length of the step for which the Jacobian was taken")
BEARS = column("iteration", "s", "longest step for which stages are likely to be found")

OPEN_LIMIT = column("audit", "", "openness beyond which a step is rejected")
UNREST_LIMIT = column("audit", "", "share of the turnover beyond which unrest rejects a step")
FLOOR = column("audit", "J", "energy below which unrest is rounding")
STARTED = column("audit", "", "1 once the energies of the start are known")
TOTAL_0 = column("audit", "J", "all energy at the start")
WORK_0 = column("audit", "J", "work done at the start")
MOST_KINETIC = column("audit", "J", "largest kinetic energy so far")
MOST_WORK = column("audit", "J", "largest work so far")
LEAST_POTENTIAL = column("audit", "J", "smallest potential energy so far")
MOST_POTENTIAL = column("audit", "J", "largest so far")
MOST_UNREST = column("audit", "J", "largest unrest so far")
OPEN_ANGLE = column("audit", "rad", "largest angle by which joints were open")
OPEN_LENGTH = column("audit", "m", "largest length")
OPENNESS = column("audit", "", "of the present step: largest residual, relative to the mechanism's size or 1 rad")
OPEN_ROW = column("audit", "", "the row with that residual")
UNREST = column("audit", "", "of the present step: energy error as a share of the turnover")
CORRECTION = column("audit", "", "openness that was corrected in the present step")
SUNK = column("audit", "",
    "largest depth of a set-valued contact in its wall, as a share of GAP_SCALE, Moreau-Jean only")
KINETIC_NOW = column("audit", "J", "kinetic energy at the state checked last")
WORK_NOW = column("audit", "J", "work done there")
POTENTIAL_NOW = column("audit", "J", "potential energy there")
UNREST_NOW = column("audit", "J", "unrest there")

LANDS = column("landing", "", "1 + switch at which the step ends; 0: none")
GO_ON = column("landing", "s", "next step")
TURNS = column("landing", "", "switchings so far")
LAST_TURN = column("landing", "s", "time of the last one")
AGAIN = column("landing", "", "switchings without progress in time")
PATIENCE = column("landing", "", "how often the modes of joints were kept for a little because they went to and fro")
PATIENT_UNTIL = column("landing", "s", "until when they are kept")
LANDS_IN = column("landing", "s", "length of the step that ends there")

LOOP = column("course", "", "RUNS_SMOOTHLY, RUNS_BY_EVENTS or RUNS_EQUAL_STEPS, see `run_loop`")
EXTENT = column("course", "m", "size of the mechanism")
PIECE = column("course", "", "number of instants of the timetable that are passed")
JOLTS = column("course", "", "jumps of drivers that are passed")
MAY_PASS = column("course", "", "1 if a contact passes jams")
JAMS = column("course", "", "jams passed")
JAM_AT = column("course", "s", "the last of them")
FIRST_JAM = column("course", "s", "the first")
LEG_START = column("course", "s", "start of the run, if it had taken the present equal steps from there")
LEG_END = column("course", "s", "instant at which they end")
LEG_STEP = column("course", "s", "their length")
LEG_STEPS = column("course", "", "steps of the run at that instant")
RUNS_SMOOTHLY, RUNS_BY_EVENTS, RUNS_EQUAL_STEPS = range(3)
JUMP_AT = column("driver_jump", "s", "instant")
JUMP_ROW = column("driver_jump", "", "first row of the driver")
JUMP_IMPULSE = column("driver_jump", "N*s or N*m*s", "of the driver on its body B, once it is passed")
JUMP_WORK = column("driver_jump", "J", "done by the driver")
JUMP_SIZE = column("driver_jump", "rad/s or m/s", "speed after minus speed before")
JUMP_DRIVER = column("driver_jump", "", "number of the driver")

LEAP_SLOT = column("driver_leap", "", "place of the driver's function in `values`")
LEAP_ROW = column("driver_leap", "", "first row of the driver")
LEAP_SCALE = column("driver_leap", "m or rad", "size of the mechanism, or 1 rad")
VALUE_BEFORE = column("driver_leap", "m or rad", "its function just before the instant at hand")
SPEED_BEFORE = column("driver_leap", "m/s or rad/s", "its speed there")
FASTEST = column("driver_leap", "m/s or rad/s", "its largest speed beside all instants")
LEAP_COUNT = column("driver_leap", "", "jumps in position")
LEAP_AT = column("driver_leap", "s", "the first of them")
LEAP_SIZE = column("driver_leap", "m or rad", "by how much")

FIRST_CODE = column("timed", "", "first row of its program in `code`; of a switch, of that of its operands")
END_CODE = column("timed", "", "row after the last one")
OWN_CODE = column("timed", "", "row of the switch itself")
DRIVES = column("timed", "", "1 if a driver depends on it")
RESOLVED = column("timed", "", "0 if it has too many instants to follow")
FIRST_FOUND = column("timed", "", "its first row in `switchings`")
END_FOUND = column("timed", "", "row after the last one")
NESTED = column("timed", "", "1 if the switch that is being searched depends on it, scratch")
NEXT = column("timed", "", "row in `switchings` of the instant at hand, scratch")

SPENT = column("search", "", "rows of programs evaluated, times spans")
FILLED = column("search", "", "rows of `switchings` filled")
ROWS = column("search", "", "rows of the programs of the switching function that is searched")
CUT = column("search", "s", "up to where its sides are known")
SIDE_THERE = column("search", "", "its side there")
LOOKS = column("search", "", "spans that were looked at")

SWITCHES_AT = column("switchings", "s", "instant")
SIDE_AFTER = column("switchings", "", "side from there on")

CROSSING_T = column("crossings", "s", "instant")
CROSSING_FORCE = column("crossings", "", "number of the monitored force")
CROSSING_SIGN = column("crossings", "", "its new sign")

EVENT_T = column("events", "s", "instant")
EVENT_CONTACT = column("events", "", "number of the contact")
EVENT_KIND = column("events", "", "kind of event")
EVENT_SPEED = column("events", "m/s or rad/s", "along the normal")
EVENT_DURATION = column("events", "s", "of a contact that has ended")
EVENT_PEAK = column("events", "N or N*m", "its largest force")
EVENT_IMPULSE = column("events", "N*s or N*m*s", "impulse")
EVENT_LOSS = column("events", "J", "energy lost")
CONTACT_EVENT, RELEASE_EVENT, IMPACT_EVENT, STICK_EVENT, SLIP_EVENT = 0.0, 1.0, 2.0, 3.0, 4.0
FORM = column("quantity", "",
    "how it is formed from its columns: OF_VECTOR, OF_SIZE, OF_VALUE, OF_NEGATIVE or OF_LARGER")
FIRST_COLUMN = column("quantity", "", "its first column after those of bodies")
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
A_IN = column("port_work", "J", "energy given to A by impulses so far")
A_OUT = column("port_work", "J", "energy taken from A")
B_IN = column("port_work", "J", "energy given to B")
B_OUT = column("port_work", "J", "energy taken from B")
A_NOW = column("port_work", "J", "energy given to A by the present impulse, scratch")
B_NOW = column("port_work", "J", "the same of B")
