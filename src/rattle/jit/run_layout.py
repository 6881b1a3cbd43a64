"""Columns of the arrays that a run carries from step to step and of what it writes; `layout` has their names too."""

from __future__ import annotations

from rattle.jit.columns import declare

# fmt: off
# ---------------------------------------------------------------- a run
declare("clock", """
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
    COLLAPSED [] steps in a row that were far too short to get anywhere
""")
T, H, H_MIN, TROUBLE, H_SOUND, H_FREE, FEWEST, CHANGE_AT, H_STABLE, SHORTENED, COLLAPSED = range(11)
declare("stepper", """
    ADAPTIVE [] 1 if its steps follow the tolerances
    ERROR_POWER [] power of the step with which the error of one step grows
    STAGES [] of a step
    SLOPES [] rows of `slopes` whose accelerations bound those in a step
    DENSE_STAGES [] further stages of its dense output
    STABLE [] step times fastest rate beyond which it is not stable; 0: not watched
""")
ADAPTIVE, ERROR_POWER, STAGES, SLOPES, DENSE_STAGES, STABLE = range(6)
declare("stepper_table", """
    STEP [] takes a step
    DENSE [] completes its dense output
""")
STEP, DENSE = range(2)
declare("tally", """
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
declare("passage", """
    ROOT_BEFORE [] root of the least pivot share at the start of the step, see `singular_passage`
    ROOT_WITHIN [] least one at its stages
    ROOT_AFTER [] at its end
    TRIED_AT [s] start of a step that was laid across a singular position
    USUAL_LOST [] redundant rows at the start of the run
    ROOT_SLOPE [] of the root over the step, next to the singular position
    PASSED_SHARE [] share of the step at which it passes it
    ROOT_THERE [] root there
    NEARBY [] AWAY, BEFORE or PASSED of `singular_passage`
    PASSED [] singular positions passed
    CLOSEST_ROOT [] least root since it is not AWAY
    NEAR_SINCE [s] time since when it is not AWAY
    SUSPECTS [] rows whose pivot may vanish inside the step
""")
ROOT_BEFORE, ROOT_WITHIN, ROOT_AFTER, TRIED_AT, USUAL_LOST, ROOT_SLOPE, PASSED_SHARE, ROOT_THERE, NEARBY = range(9)
PASSED, CLOSEST_ROOT, NEAR_SINCE, SUSPECTS = range(9, 13)
declare("passages", """
    PASSED_AT [s] instant
    PASSED_ROOT [] root there
    PASSED_FROM [s] from here on forces do not count
    PASSED_UNTIL [s] until here
""")
PASSED_AT, PASSED_ROOT, PASSED_FROM, PASSED_UNTIL = range(4)
declare("iteration", """
    JACOBIAN_T [s] time of the state at which the Jacobian was taken
    STALE [] 1 if there is none, or if the iteration with it was slow
    FACTORED_H [s] step for which its matrices are factored; 0: none
    KEPT_T [s] start of the step whose stages are kept
    KEPT_H [s] its length; 0: none is kept
    ROUNDS [] iterations for the stages of the last step
    CONTRACTION [] ratio of the last two corrections
    FAILED [] 1 if the last attempt found no stages
    JACOBIAN_H [s] length of the step for which the Jacobian was taken
    BEARS [s] longest step for which stages are likely to be found
""")
JACOBIAN_T, STALE, FACTORED_H, KEPT_T, KEPT_H, ROUNDS, CONTRACTION, FAILED, JACOBIAN_H, BEARS = range(10)
declare("audit", """
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
    MOST_UNREST [J] largest unrest so far
    OPEN_ANGLE [rad] largest angle by which joints were open
    OPEN_LENGTH [m] largest length
    OPENNESS [] of the present step: largest residual, relative to the mechanism's size or 1 rad
    OPEN_ROW [] the row with that residual
    UNREST [] of the present step: energy error as a share of the turnover
    CORRECTION [] openness that was corrected in the present step
    SUNK [] largest depth of a set-valued contact in its wall, as a share of GAP_SCALE, Moreau-Jean only
    KINETIC_NOW [J] kinetic energy at the state checked last
    WORK_NOW [J] work done there
    POTENTIAL_NOW [J] potential energy there
    UNREST_NOW [J] unrest there
""")
OPEN_LIMIT, UNREST_LIMIT, FLOOR, STARTED, TOTAL_0, WORK_0, MOST_KINETIC, MOST_WORK, LEAST_POTENTIAL = range(9)
MOST_POTENTIAL, MOST_UNREST, OPEN_ANGLE, OPEN_LENGTH, OPENNESS, OPEN_ROW, UNREST, CORRECTION, SUNK = range(9, 18)
KINETIC_NOW, WORK_NOW, POTENTIAL_NOW, UNREST_NOW = range(18, 22)
declare("landing", """
    LANDS [] 1 + switch at which the step ends; 0: none
    GO_ON [s] next step
    TURNS [] switchings so far
    LAST_TURN [s] time of the last one
    AGAIN [] switchings without progress in time
    LANDS_IN [s] length of the step that ends there
""")
LANDS, GO_ON, TURNS, LAST_TURN, AGAIN, LANDS_IN = range(6)
declare("course", """
    LOOP [] RUNS_SMOOTHLY, RUNS_BY_EVENTS or RUNS_EQUAL_STEPS, see `run_loop`
    EXTENT [m] size of the mechanism
    PIECE [] number of instants of the timetable that are passed
    JOLTS [] jumps of drivers that are passed
    MAY_PASS [] 1 if a contact passes jams
    JAMS [] jams passed
    JAM_AT [s] the last of them
    FIRST_JAM [s] the first
    LEG_START [s] start of the run, if it had taken the present equal steps from there
    LEG_END [s] instant at which they end
    LEG_STEP [s] their length
    LEG_STEPS [] steps of the run at that instant
""")
LOOP, EXTENT, PIECE, JOLTS, MAY_PASS, JAMS, JAM_AT, FIRST_JAM, LEG_START, LEG_END = range(10)
LEG_STEP, LEG_STEPS = range(10, 12)
RUNS_SMOOTHLY, RUNS_BY_EVENTS, RUNS_EQUAL_STEPS = range(3)
declare("driver_jump", """
    JUMP_AT [s] instant
    JUMP_ROW [] first row of the driver
    JUMP_IMPULSE [N*s or N*m*s] of the driver on its body B, once it is passed
    JUMP_WORK [J] done by the driver
    JUMP_SIZE [rad/s or m/s] speed after minus speed before
    JUMP_DRIVER [] number of the driver
""")
JUMP_AT, JUMP_ROW, JUMP_IMPULSE, JUMP_WORK, JUMP_SIZE, JUMP_DRIVER = range(6)
declare("driver_leap", """
    LEAP_SLOT [] place of the driver's function in `values`
    LEAP_ROW [] first row of the driver
    LEAP_SCALE [m or rad] size of the mechanism, or 1 rad
    VALUE_BEFORE [m or rad] its function just before the instant at hand
    SPEED_BEFORE [m/s or rad/s] its speed there
    FASTEST [m/s or rad/s] its largest speed beside all instants
    LEAP_COUNT [] jumps in position
    LEAP_AT [s] the first of them
    LEAP_SIZE [m or rad] by how much
""")
LEAP_SLOT, LEAP_ROW, LEAP_SCALE, VALUE_BEFORE, SPEED_BEFORE, FASTEST, LEAP_COUNT, LEAP_AT, LEAP_SIZE = range(9)
declare("timed", """
    FIRST_CODE [] first row of the program of its operands in `code`
    END_CODE [] row after the last one
    OWN_CODE [] row of the switch itself
    DRIVES [] 1 if a driver depends on it
    RESOLVED [] 0 if it has too many instants to follow
    FIRST_FOUND [] its first row in `switchings`
    END_FOUND [] row after the last one
    NESTED [] 1 if the switch that is being searched depends on it, scratch
    NEXT [] row in `switchings` of the instant at hand, scratch
""")
DRIVES, RESOLVED, FIRST_FOUND, END_FOUND, NESTED, NEXT = range(3, 9)
declare("search", """
    SPENT [] rows of programs evaluated, times spans
    FILLED [] rows of `switchings` filled
    ROWS [] rows of the programs of the switching function that is searched
    CUT [s] up to where its sides are known
    SIDE_THERE [] its side there
    LOOKS [] spans that were looked at
""")
SPENT, FILLED, ROWS, CUT, SIDE_THERE, LOOKS = range(6)
declare("switchings", """
    SWITCHES_AT [s] instant
    SIDE_AFTER [] side from there on
""")
SWITCHES_AT, SIDE_AFTER = range(2)
declare("crossings", """
    CROSSING_T [s] instant
    CROSSING_FORCE [] number of the monitored force
    CROSSING_SIGN [] its new sign
""")
CROSSING_T, CROSSING_FORCE, CROSSING_SIGN = range(3)
declare("events", """
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
declare("quantity", """
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
declare("port_work", """
    A_IN [J] energy given to A by impulses so far
    A_OUT [J] energy taken from A
    B_IN [J] energy given to B
    B_OUT [J] energy taken from B
    A_NOW [J] energy given to A by the present impulse, scratch
    B_NOW [J] the same of B
""")
A_IN, A_OUT, B_IN, B_OUT, A_NOW, B_NOW = range(6)
