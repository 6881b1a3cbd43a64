"""Names of the columns of the arrays in a workspace, in the letters of the kernels.

`body` is an array (nb + 1, 8), one row per body, row 0 the ground; `rows` is an array (nr, 9), one
row per constraint.  Units are SI, as listed with each array in `rattle.jit.workspace`.
"""

from __future__ import annotations

# columns of `body`: mass centre [m], angle [rad], their rates, cosine and sine of the angle
X, Y, PHI, VX, VY, W, COS, SIN = range(8)
# columns of `rows`: residual Phi, nu, gamma, then the Jacobian with respect to x, y, phi of A and of B
RES, NU, GAMMA, AX, AY, AP, BX, BY, BP = range(9)
# columns of `energy`: potential [J]; power of the elastic part, power from outside, dissipation [W]
POTENTIAL, ELASTIC, OUTSIDE, DISSIPATED = range(4)
# columns of `contact`: kernels and first parameters of its geometry and laws, joint and bodies to which it belongs
SHAPE, A_BODY, B_BODY, SHAPE_P, CORNER, STATIC, STATIC_P, NORMAL_LAW, NORMAL_P, FRICTION, FRICTION_P, OWNER, IMPACT = (
    range(13)
)
FIRST_STATE, STATES = 13, 14  # of its friction law among the states of elements, and how many
# parameters of a joint, driver or load between two points start with these (x, y each); those of contacts go on with
# the clearance, the radius of the bush, the fields of the joint and its dimensions
POINTS = 4
CLEARANCE, RADIUS, FIELDS = 4, 5, 6
# parameters of a set-valued contact: the fields of `impact` in their order
RESTITUTION, TANGENTIAL_RESTITUTION, MU, RESTITUTION_LAW, JAM = range(5)
# columns of `joint`: kernel, bodies A and B, first parameter, first row; those of `load` differ in the last one: 1 if
# its values change during the run
KERNEL, END_A, END_B, FIRST_P, FIRST_ROW = range(5)
CHANGES = 4
# columns of `lever`: lever arms on A and B [m]; 1 if straight walls turn with A; 1 if a wall is curved
ARM_A, ARM_B, WALLS_TURN, ROUNDED = range(4)
# columns of `contact_kinematics`: gap g (negative: penetration) and its rate; normal n from A outwards (the force on
# B is -N n - T t, t = n turned by 90 degrees); arms of the contact point from the mass centres of A and B; slip u . t
# of B's material against A's; gamma of the normal and tangential rows; N, T and the rates they give; speed of a pin's
# centre along t
GAP, DGAP, NX, NY, PAX, PAY, PBX, PBY, SLIP, GAMMA_N, GAMMA_T, NORMAL, TANGENT, LOSS, STORE, ACROSS = range(16)
# columns of `contact_memory`: state, approach speed, time, impulse and loss at its start, peak force,
# steps so far; gap, its rate and N at the start and at the end of the present step
CLOSED, SPEED, SINCE, PEAK, IMPULSE_0, LOSS_0, STEPS_IN, GAP_0, DGAP_0, N_0, GAP_1, DGAP_1, N_1 = range(13)
# columns of `events`: time, contact, kind, normal speed, duration, peak force, impulse, energy lost; the kinds
EVENT_T, EVENT_CONTACT, EVENT_KIND, EVENT_SPEED, EVENT_DURATION, EVENT_PEAK, EVENT_IMPULSE, EVENT_LOSS = range(8)
CONTACT_EVENT, RELEASE_EVENT, IMPACT_EVENT, STICK_EVENT, SLIP_EVENT = 0.0, 1.0, 2.0, 3.0, 4.0
# how a quantity with peaks is formed from its columns of an output row: length of a vector, magnitude of a number, the
# number, or its negative
OF_VECTOR, OF_SIZE, OF_VALUE, OF_NEGATIVE = range(4)
# one output row: the columns of every body, then of every joint and driver, the signals, the energies; names as in a
# result, with their units
OUTPUT_BODY = {
    "x": "m", "y": "m", "angle": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s",
    "ax": "m/s^2", "ay": "m/s^2", "alpha": "rad/s^2",
}  # fmt: skip
# force on B, its moment about the joint's point on B, offset of that point from the one on A; minus the multiplier of
# the first row, work rate of the rows; N, T and penetration of the contacts
OUTPUT_JOINT = {
    "fx": "N", "fy": "N", "moment": "N*m", "ex": "m", "ey": "m", "effort": "N or N*m", "power": "W",
    "normal": "N", "tangential": "N", "penetration": "m",
}  # fmt: skip
OUTPUT_ENERGY = {"kinetic": "J", "potential": "J", "work": "J", "dissipated": "J"}
PER_BODY, PER_JOINT, ENERGIES = len(OUTPUT_BODY), len(OUTPUT_JOINT), len(OUTPUT_ENERGY)
PLACE, RATE, RATE_RATE = 0, 3, 6  # of a body: first of x, y, angle, of their rates and of their accelerations
FX, FY, MOMENT, EX, EY, EFFORT, POWER, JOINT_NORMAL, JOINT_TANGENT, PENETRATION = range(PER_JOINT)
KINETIC, STORED, WORK, LOST = range(ENERGIES)
OPEN, SHUT, AUTO = 0.0, 1.0, 2.0  # AUTO: in contact whenever there is penetration (statics)
