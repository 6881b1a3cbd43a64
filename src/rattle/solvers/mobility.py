"""The mobility method: the path of a pin in its oil film under a force that is known as a function of time.

A film has no inertia.  At a place e of the pin its force is a monotone function of one velocity, v = e' - w_m z x e, so
the force that it has to exert says how the pin moves:

    film(e, v) = F - dry(e)         e' = v + w_m z x e         w_m = (w_A + w_B)/2

F is the force of the joint on the pin, dry that of the dry contact beyond the boundary film: its elastic force and the
friction of the turning, (w_B - w_A)(h - |e|/2) with h the arm of the contact on A.  All laws of films have forces of
degree one in v: its direction is the root of one equation, as a film that loses energy resists within 90 degrees of v,
and its size follows.  The differential equation is of first order and not stiff.

Source: Booth (1965), J. Basic Eng. 87, 187-198, with the exact inverse in place of fitted mobilities.
"""

from __future__ import annotations

import math

from rattle.elements.film_frame import CLEARANCE, LEAST
from rattle.jit import layout as at
from rattle.jit.families import call_film, call_friction, call_stiffness
from rattle.jit.functions import compiled, native
from rattle.solvers.dop853_tableau import E3, E5, TABLEAU, A, B, C
from rattle.solvers.step_size import SAFETY, error_share, longer, shorter

STAGES, POWER = TABLEAU.stages, TABLEAU.order
ROUNDS = 60  # of the search for a direction
NARROW = 1e-15  # width of its bracket [rad] that is as good as none
ALIGNED = 1e-14  # sine of the angle between two forces below which they have the same direction
NOW, STRIDE, X, Y, TAKEN = range(5)  # of `clock`: t [s], next step [s], place of the pin [m], steps so far
E_X, E_Y, RATE_X, RATE_Y, NORMAL, TANGENT, MOMENT = range(7)  # columns of an output row
# of `course`: F_x, F_y [N], w_A, w_B [rad/s], each four coefficients of a cubic, the third power first
QUANTITIES = 4
UP_TO = 1e-9  # share of what is left by which a step may end before its target and still be the last one


@compiled
def carried_at(t, nodes, course, k):
    """Quantity k of `course` at t [s]: a cubic in t - nodes[i] between nodes i and i + 1."""
    low, high = 0, nodes.shape[0] - 2
    while low < high:
        middle = (low + high + 1) // 2
        if nodes[middle] <= t:
            low = middle
        else:
            high = middle - 1
    s = t - nodes[low]
    third, second, first = course[low, k], course[low, QUANTITIES + k], course[low, 2 * QUANTITIES + k]
    return ((third * s + second) * s + first) * s + course[low, 3 * QUANTITIES + k]


@native("void", "h", "i", "f", "f", "f", "f", "f", "f")
def film_at(m, n, ex, ey, vx, vy, wa, wb):
    """Force [N], moments [N m] and loss [W] of the film of contact n into `film_force`; see `rattle.elements.film`."""
    contact = m.contact
    arguments = (ex, ey, vx, vy, wa, wb, m.values, contact[n, at.FILM_P], m.film_coefficients, m.film_force)
    call_film(m.film_table[contact[n, at.FILM_LAW]], arguments)


@compiled
def dry_forces(m, n, ex, ey, wa, wb):
    """Normal and friction force [N] of the dry contact n: elastic, with the friction of the turning."""
    contact, values, none = m.contact, m.values, m.film_force
    p = contact[n, at.SHAPE_P]
    size = math.sqrt(ex * ex + ey * ey)
    depth = size - values[p + at.CLEARANCE]
    if depth <= 0.0:
        return 0.0, 0.0
    normal = call_stiffness(m.stiffness_table[contact[n, at.STATIC]], (depth, values, contact[n, at.STATIC_P]))
    if contact[n, at.FRICTION] < 0 or contact[n, at.STATES] > 0:
        return normal, 0.0
    arm = values[p + at.RADIUS] + 0.5 * depth
    slip = (wb - wa) * (arm - 0.5 * size)
    arguments = (slip, normal, none, values, contact[n, at.FRICTION_P], none)
    return normal, call_friction(m.friction_table[contact[n, at.FRICTION]], arguments)


@native("void", "h", "i", "f", "f", "f", "v")
def still_force(m, n, size, wa, wb, out):
    """Force [N] on a pin that stays at e = (size, 0) [m] while both bodies turn: of film and dry contact n."""
    normal, tangent = dry_forces(m, n, size, 0.0, wa, wb)
    film_at(m, n, size, 0.0, 0.0, 0.0, wa, wb)
    out[0], out[1] = m.film_force[0] - normal, m.film_force[1] - tangent


@compiled
def turned(m, n, ex, ey, dx, dy, x):
    """The film at a speed of 1 m/s in the direction d turned by x [rad]: sine of the angle from d to what resists.

    Then the size of the force [N], and the direction.
    """
    out, cos, sin = m.film_force, math.cos(x), math.sin(x)
    mx, my = dx * cos - dy * sin, dy * cos + dx * sin
    film_at(m, n, ex, ey, mx, my, 0.0, 0.0)
    strength = math.sqrt(out[0] * out[0] + out[1] * out[1])
    return (dy * out[0] - dx * out[1]) / strength, strength, mx, my


@compiled
def narrowed(low, high, g_low, g_high, x, g):
    """A bracket of a root and the values at its ends, with the value g at x inside it known."""
    if g > 0.0 and x < high:
        return low, x, g_low, g
    if g <= 0.0 and x > low:
        return x, high, g, g_high
    return low, high, g_low, g_high


@compiled
def seen_velocity_for(m, n, ex, ey, fx, fy):
    """Velocity [m/s] that the film of contact n has to see at e [m] to exert the force (fx, fy) [N] on the pin."""
    size = math.sqrt(fx * fx + fy * fy)
    if size == 0.0:
        return 0.0, 0.0
    dx, dy = -fx / size, -fy / size
    low, high, g_low, g_high = -0.5 * math.pi, 0.5 * math.pi, -1.0, 1.0
    strength, mx, my = 1.0, dx, dy
    for _ in range(ROUNDS):  # Ridders' method
        middle = 0.5 * (low + high)
        g_middle, strength, mx, my = turned(m, n, ex, ey, dx, dy, middle)
        if abs(g_middle) <= ALIGNED:
            break
        x = middle - (high - low) * 0.5 * g_middle / math.sqrt(g_middle * g_middle - g_low * g_high)
        g, strength, mx, my = turned(m, n, ex, ey, dx, dy, x)
        if abs(g) <= ALIGNED:
            break
        low, high, g_low, g_high = narrowed(low, high, g_low, g_high, middle, g_middle)
        low, high, g_low, g_high = narrowed(low, high, g_low, g_high, x, g)
        if not high - low > NARROW:
            break
    return size / strength * mx, size / strength * my


@compiled
def rate_at(m, n, t, ex, ey, nodes, course):
    """e' [m/s] of the pin at e [m] and t [s], normal and friction force [N] of the dry contact."""
    wa, wb = carried_at(t, nodes, course, 2), carried_at(t, nodes, course, 3)
    fx, fy = carried_at(t, nodes, course, 0), carried_at(t, nodes, course, 1)
    normal, tangent = dry_forces(m, n, ex, ey, wa, wb)
    if normal != 0.0 or tangent != 0.0:  # the dry force on the pin is -N n - T t
        over = 1.0 / math.sqrt(ex * ex + ey * ey)
        nx, ny = ex * over, ey * over
        fx += normal * nx - tangent * ny
        fy += normal * ny + tangent * nx
    ux, uy = seen_velocity_for(m, n, ex, ey, fx, fy)
    wm = 0.5 * (wa + wb)
    return ux - wm * ey, uy + wm * ex, normal, tangent


@compiled
def step(m, n, t, h, x, y, nodes, course, tolerance, k):
    """The place [m] after a step from t [s] of length h [s], and its error over the tolerance.

    tolerance: share of the film's thickness, no less than that of the boundary film; k (12, 2): scratch.
    """
    for s in range(STAGES):
        px, py = x, y
        for j in range(s):
            px += h * A[s, j] * k[j, 0]
            py += h * A[s, j] * k[j, 1]
        k[s, 0], k[s, 1], _normal, _tangent = rate_at(m, n, t + C[s] * h, px, py, nodes, course)
    far_x, far_y, error3, error5 = x, y, 0.0, 0.0
    for q in range(2):
        e3, e5 = 0.0, 0.0
        for s in range(STAGES):
            e3 += E3[s] * k[s, q]
            e5 += E5[s] * k[s, q]
        error3 += e3 * e3
        error5 += e5 * e5
    for s in range(STAGES):
        far_x += h * B[s] * k[s, 0]
        far_y += h * B[s] * k[s, 1]
    values, p = m.values, m.contact[n, at.FILM_P]
    c, boundary = values[p + CLEARANCE], values[p + CLEARANCE] * values[p + LEAST]
    thin = c - max(math.sqrt(x * x + y * y), math.sqrt(far_x * far_x + far_y * far_y))
    return far_x, far_y, error_share(h, error5, error3, 1) / (tolerance * max(thin, boundary))


@compiled
def write_place(m, n, t, x, y, nodes, course, row):
    """Write place, its rate, the dry forces and the moment of the film on the pin at t [s] into a row."""
    dx, dy, normal, tangent = rate_at(m, n, t, x, y, nodes, course)
    wa, wb = carried_at(t, nodes, course, 2), carried_at(t, nodes, course, 3)
    film_at(m, n, x, y, dx, dy, wa, wb)
    row[E_X], row[E_Y], row[RATE_X], row[RATE_Y] = x, y, dx, dy
    row[NORMAL], row[TANGENT], row[MOMENT] = normal, tangent, m.film_force[3]


@native("i", "h", "i", "v", "m", "v", "f", "f", "v", "m", "m")
def follow(m, n, nodes, course, times, tolerance, most, clock, k, out):
    """Follow the pin of contact n through the times (n,) [s], a row of `out` for each; returns the rows written.

    nodes, course: see `carried_at`.  tolerance: as in `step`.  most: steps after which the call returns.  The call
    also returns where no step succeeds: the next step is then zero.
    """
    done, taken = 0, 0.0
    while done < times.shape[0] and taken < most:
        t, target = clock[NOW], times[done]
        if t >= target:
            write_place(m, n, t, clock[X], clock[Y], nodes, course, out[done])
            done += 1
            continue
        h = min(clock[STRIDE], target - t)
        last = h >= (target - t) * (1.0 - UP_TO)
        x, y, error = step(m, n, t, h, clock[X], clock[Y], nodes, course, tolerance, k)
        taken += 1.0
        if not error <= 1.0:
            clock[STRIDE] = shorter(h, error, POWER, SAFETY)
            if t + clock[STRIDE] == t:
                clock[STRIDE] = 0.0
                break
            continue
        clock[NOW] = target if last else t + h
        clock[X], clock[Y] = x, y
        ahead = longer(h, error, POWER, SAFETY)
        clock[STRIDE] = max(clock[STRIDE], ahead) if last else ahead
    clock[TAKEN] += taken
    return done
