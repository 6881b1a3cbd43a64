"""Work arrays of a run, addressed by name.

A compiled function takes the workspace `m` and reads its arrays by name, and their columns by the names in
`rattle.jit.layout`: `m.body[i, at.COS]`.  In machine code a workspace is a pointer to a table of addresses and
shapes, so a call passes one argument, whatever the number of arrays (with named tuples of forty arrays the four-bar
took 2.5 times as long to run and 1.5 times as long to compile); in plain Python it holds the arrays themselves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.address import address_of


class Array(NamedTuple):
    """One array of a workspace.

    kind: f float64, i int64, and the number of dimensions; a table of kernels is a vector of addresses.
    shape: nb bodies, nj joints and drivers, nr constraint rows, nl loads, nc contact points, ns recorded quantities
    (states of the model, signals), np parameters,
    nw monitored forces, ny numbers of a state, nk rows of program code.
    """

    kind: str
    shape: str
    unit: str
    meaning: str


ARRAYS = {
    # the mechanism: read-only in a run
    "mass": Array("f2", "nb + 1, 3", "kg, kg, kg*m^2", "m, m, J of every body; row 0 is the ground"),
    "weight": Array(
        "f2", "nb + 1, 3", "1/kg, 1/kg, 1/(kg*m^2)", "1 / mass, zero for the ground; 1 / e where there is no mass"
    ),
    "massless": Array("i2", "n, 2", "", "bodies and coordinates (0, 1, 2) without inertia, see `equations.massless`"),
    "gravity": Array("f1", "2", "m/s^2", "acceleration of free fall, at t = 0 where it is a function of time"),
    "joint": Array("i2", "nj, 5", "", "joints, then drivers"),
    "load": Array("i2", "nl, 5", "", "loads"),
    "contact": Array("i2", "nc, 26", "", "geometry and laws of every contact point"),
    "lever": Array("f2", "nc, 11", "m or rad", "what bounds the gap of every contact, and by what it is judged"),
    "code": Array(
        "i2", "nk, 4", "", "programs of all expressions, one after the other, with the branches of their switches"
    ),
    "const": Array("f1", "numbers", "SI", "numbers in them"),
    "jet": Array("i2", "drivers, 4", "", "program of every driver's function, or of its speed"),
    "jet_signal": Array("i2", "signals, 3", "", "program of every signal that a driver uses"),
    "signal": Array("i2", "ns, 3", "", "program of every signal"),
    "live": Array("i2", "values, 3", "", "program of every changing value of a load"),
    "falling": Array("i2", "0 or 2, 3", "", "programs of gravity along x and y, where it is a function of time"),
    "state_rate": Array("i2", "states of the model, 3", "", "program of the rate of every state of the model"),
    "switch": Array("i2", "switches, 4", "", "switches of expressions that depend on the state"),
    "watch": Array("i1", "nw", "", "rows whose force must not become negative (massless links)"),
    "place": Array("i1", "nr", "", "position of each row in the order of elimination, see `schur.Pattern`"),
    "first": Array("i1", "nr + 1", "", "first entry of each column of L in `below`"),
    "below": Array("i1", "entries of L", "", "position of the row of each entry of L"),
    "target": Array("i1", "updates", "", "entry of `schur` that each update of the elimination changes"),
    "pairs": Array("i2", "products, 6", "", "products of two rows at a body that make up `schur`"),
    "row_body": Array("i2", "nr, 2", "", "bodies A, B of every row"),
    "joint_table": Array("i1", "kinds", "", "kernels of joints and drivers"),
    "load_table": Array("i1", "kinds", "", "kernels of loads"),
    "clearance_table": Array("i1", "kinds", "", "kernels of clearances, one-sided joints, stops and clutches"),
    "stiffness_table": Array("i1", "kinds", "", "kernels of static contact forces"),
    "normal_table": Array("i1", "kinds", "", "kernels of normal forces"),
    "friction_table": Array("i1", "kinds", "", "kernels of friction"),
    "film_table": Array("i1", "kinds", "", "kernels of oil films"),
    "film_coefficients": Array("f1", "numbers", "", "tables that they read, one after the other"),
    # this instant, in the order in which it is filled
    "values": Array("f1", "np", "SI", "parameters of joints, drivers, loads and contacts"),
    "signals": Array("f1", "ns", "SI", "states of the model, then values of signals"),
    "travelled": Array(
        "f1", "0 or 1", "s", "when the travels in `signals` are those of drivers; nan: they are those of a state y"
    ),
    "jets": Array("f2", "ns, 3", "SI", "value, first and second derivative of the signals that drivers use"),
    "stack": Array("f1", "depth", "SI", "scratch of expressions"),
    "jet_stack": Array("f1", "3 depth", "SI", "the same for expressions with derivatives"),
    "jet_out": Array("f1", "3", "SI", "value and derivatives of one expression"),
    "body": Array("f2", "nb + 1, 8", "m, rad, m/s, rad/s", "state of every body; row 0 is the ground"),
    "rows": Array("f2", "nr, 9", "m or rad", "residual, nu, gamma and Jacobian of every constraint row"),
    "force": Array("f2", "nb + 1, 3", "N, N, N*m", "applied forces Q"),
    "energy": Array("f1", "4", "J, W", "of one load"),
    "power": Array("f1", "5", "", "of all loads, and how sound the factor is"),
    "schur": Array("f1", "nr + entries of L", "", "Schur complement and its factor"),
    "inverse": Array("f1", "nr", "", "1 / pivot, in the order of elimination"),
    "redundant": Array("i1", "nr", "", "1 if a row is redundant, in the order of elimination"),
    "pivots_of_row": Array("f2", "nr, 6", "", "pivots, in the order of elimination, see `singular_passage`"),
    "solution": Array("f1", "nr", "", "right-hand side and solution, in the order of elimination"),
    "multiplier": Array("f1", "nr", "N or N*m", "lambda"),
    "acceleration": Array("f2", "nb + 1, 3", "m/s^2, rad/s^2", "of every body"),
    "change": Array("f1", "3 nb", "m, rad or m/s, rad/s", "a correction of positions or rates"),
    "contact_kinematics": Array("f2", "nc, 26", "m, m/s, N or rad, rad/s, N*m", "geometry and forces of every contact"),
    "turning": Array(
        "f1", "nb + 1", "rad/s", "rates that oil films see besides those of the motion: in statics, those of drivers"
    ),
    "film_force": Array("f1", "5", "N, N*m, W", "of one oil film, scratch"),
    "bin_sums": Array("f1", "8", "N, N*m, W", "sums over the bins of one worn contact, scratch"),
    "contact_memory": Array("f2", "nc, 28", "", "memory of every contact"),
    "element_state": Array("f1", "all states", "SI", "of friction laws, then of the model; see `equations.state`"),
    "element_rate": Array("f1", "all states", "SI/s", "their rates"),
    # set-valued contacts; two rows (normal, tangential) for each active contact
    "mode": Array("i1", "nc", "", "mode of each contact: OFF, STICK, FORWARD, BACKWARD"),
    "active": Array("i1", "nc", "", "active contacts"),
    "candidate": Array("i1", "nc", "", "candidate modes of the active contacts"),
    "slide": Array("i1", "nc", "", "sign of their slip if it is prescribed, otherwise 0"),
    "pivots": Array("i1", "2 nc", "", "scratch"),
    "row_fixed": Array("i1", "2 nc", "", "rows of W that are fixed: 1 by the joints, 2 with friction that sticks"),
    "contact_jacobian": Array("f2", "2 nc, 6", "-, -, m", "W: rates of A, then of B, to normal or tangential velocity"),
    "velocity_response": Array("f2", "2 nc, 3 nb", "", "M^-1 (w - Phi_q^T z): response to a unit force"),
    "multiplier_response": Array("f2", "2 nc, nr", "", "z: multipliers caused by a unit force"),
    "delassus": Array("f2", "2 nc, 2 nc", "1/kg", "G, the Delassus matrix"),
    "side": Array("f2", "4, 2 nc", "", "b, f, a of a = G f + b, and another solution"),
    "system": Array("f2", "2 nc, 2 nc + 1", "", "scratch"),
    "recent": Array("f2", "nc, 2", "s", "last impacts of every contact"),
    "stuck": Array("f1", "4", "", "events that follow each other at once"),
    "velocity_change": Array("f2", "nb + 1, 3", "", "M^-1 (W^T f - Phi_q^T z): response to all forces f"),
    "multiplier_change": Array("f1", "nr", "", "z: multipliers caused by all forces f"),
    "path": Array("f2", "6, 2 nc", "", "b, d, and f, a for d alone, see `lemke`; modes, a or f of a solution"),
    "bounce": Array("f2", "7, 2 nc", "", "see `impact_path` and `impact_phases`"),
    "chain": Array("f2", "10, 2 nc", "", "see `impact_chain`"),
    "looks": Array("f2", "looks, 4 nc + 2", "", "samples of the indicators in a step, see `event_search`"),
    "glances": Array("f2", "n, 4 nc + 2", "", "the same at the stages of a step, see `contact_samples`"),
    "held": Array("f1", "13", "", "what is known of the contact problem at hand"),
    "net_place": Array("i1", "nr + 2 nc", "", "rows of joints and contacts together: order, see `contact_network`"),
    "net_first": Array("i1", "nr + 2 nc + 1", "", "see `place` to `pairs`"),
    "net_below": Array("i1", "entries of L", "", ""),
    "net_target": Array("i1", "updates", "", ""),
    "net_pairs": Array("i2", "products, 6", "", ""),
    "net_row": Array("i1", "nr + 2 nc", "", "row at each place"),
    "net_on": Array("i1", "nr + 2 nc", "", "1 if the row is active"),
    "net_line": Array("f2", "nr + 2 nc, 6", "", "R"),
    "net_column": Array("f2", "nr + 2 nc, 6", "", "M^-1 C^T"),
    "net_size": Array("f1", "nr + 2 nc", "", "diagonal without friction"),
    "net_lower": Array("f1", "entries", "", "factors"),
    "net_upper": Array("f1", "entries", "", ""),
    "net_x": Array("f2", "2, nr + 2 nc", "", "solution, correction, by place"),
    "closed_contacts_table": Array(
        "i1", "0 or 1", "", "the kernel that adds the forces of closed contacts, if there may be any"
    ),
    "problem_table": Array("i1", "parts", "", "kernels that solve contact problems, see `unilateral`"),
    # compliant contacts and films in time stepping, four rows for each, see `implicit_forces`
    "soft": Array("i1", "n", "", "which contacts they are"),
    "soft_place": Array("f2", "n, 2", "m", "pin centre from bush centre, of a film"),
    "soft_jacobian": Array("f2", "4 n, 6", "-, -, m", "J: rates of A, then of B, to those that the forces depend on"),
    "soft_response": Array("f2", "4 n, 3 nb", "", "M^-1 (j - Phi_q^T z): response to a unit force"),
    "soft_reaction": Array("f2", "4 n, nr", "", "z: multipliers caused by a unit force"),
    "soft_delassus": Array("f2", "4 n, 4 n", "1/kg", "G"),
    "soft_slope": Array("f2", "4 n, 4", "N*s/m", "D: derivative of the forces by their rates"),
    "soft_matrix": Array("f2", "4 n, 4 n", "", "1 - h G D, factored"),
    "soft_order": Array("i1", "4 n", "", "rows exchanged in it"),
    "soft_force": Array("f2", "9, 4 n", "", "forces and rates of the iteration"),
    "soft_free": Array("f1", "3 nb + 3 + nr", "", "accelerations and multipliers without these forces"),
    # coordinates without inertia, see `equations.massless`
    "massless_response": Array("f2", "n, 3 nb + 3", "", "Y: accelerations of all bodies caused by unit forces"),
    "massless_reaction": Array("f2", "n, nr", "", "Z: multipliers caused by unit forces"),
    "massless_system": Array("f2", "n, n", "", "1/e - P^T Y, factored"),
    "massless_force": Array("f1", "n", "N or N*m", "f: what makes up for the fictitious inertia"),
    "massless_impulse": Array("f1", "nr or 0", "", "scratch"),
    # dry friction of joints without play, see `equations.dry_friction`
    "dry": Array("i2", "nd, 13", "", "joints without play that have friction"),
    "dry_memory": Array("f2", "nd, 19", "N, m/s or N*m, rad/s", "their modes and friction forces"),
    "dry_rows": Array("f2", "nd, 9", "m or rad", "rows of their free coordinates, as `rows`"),
    "dry_response": Array("f2", "nd, 3 nb + 3", "", "Y: accelerations of all bodies caused by unit forces"),
    "dry_reaction": Array("f2", "nd, nr", "", "Z: multipliers caused by unit forces"),
    "dry_share": Array("f2", "nd, 2 nc", "", "tau per unit force of a row of the active contacts"),
    "impact_reaction": Array("f1", "nr", "N*s or N*m*s", "impulses of the joints in an impact with their friction"),
    "expected_force": Array("f1", "2 nc", "N", "forces of contacts, friction of joints being linearised there"),
    "dry_system": Array("f2", "nd, nd + 2", "", "scratch"),
    # given values at the start, see `equations.kept_values`
    "kept_rows": Array("f2", "nr, 3 nb", "-, -, m", "Phi_q as a matrix"),
    "kept_wide": Array("f2", "nr, 3 nb", "", "scratch"),
    "kept_span": Array("f2", "3 nb, nr", "", "scratch"),
    "kept_left": Array("f2", "nr, nr", "", "left null space of the columns that are not given"),
    "kept_tall": Array("f2", "nr, nr", "", "scratch"),
    "kept_pivot": Array("f2", "2, nr + 3 nb", "", "of reflections"),
    "kept_pivot_tall": Array("f2", "2, nr", "", "of those of `kept_tall`"),
    "kept_places": Array("f2", "9, 3 nb", "m, rad", "positions, rates and their changes"),
    "kept_sides": Array("f2", "5, nr", "", "what the changes are asked for"),
    "kept_order": Array("i2", "2, nr + 3 nb", "", "rows exchanged"),
    # a start, see `equations.start_columns`; all empty in a run
    "start_form": Array("i1", "9", "", "WITHOUT_PLAY to ANGLES"),
    "start_size": Array("f1", "1", "m", "of the mechanism"),
    "start_q": Array("f1", "3 nb", "m, rad", "positions of the start"),
    "start_v": Array("f1", "3 nb", "m/s, rad/s", "their rates"),
    "start_given": Array("f1", "3 nb", "m, rad", "given positions, nan if not given"),
    "start_near": Array("f1", "3 nb", "m, rad", "positions of a start near by, nan without one"),
    "start_rates": Array("f1", "3 nb", "m/s, rad/s", "given rates, nan if not given"),
    "start_least": Array("f1", "nc", "m or rad", "least gaps"),
    "start_ways": Array("i2", "n, 9", "", "joints from the ground outwards"),
    "start_moving": Array("i2", "n, 3", "", "points of the ground that move, and where x and y stand in `values`"),
    "start_offsets": Array("f2", "joints, 2", "m", "offsets of joints"),
    "start_lines": Array("f2", "joints, 3", "rad, m, rad", "direction of their line on A, distance of points, angle"),
    "start_held": Array("f2", "pins, 4", "m", "pins that can be held: point on A, offset in ground axes"),
    "start_missing": Array("i2", "n, 2", "", "those whose offset is not given, but follows from the reactions"),
    "start_first": Array("i1", "n", "", "first rows of pressed pins in the mechanism without play"),
    "start_pressed": Array("f2", "n, 3", "m", "their clearances and these offsets, see `press_pins`"),
    "start_scratch": Array("f2", "3, 3 nb", "", "scratch"),
    "start_pins": Array("i2", "n, 3", "", "of joints that are closed: body A, point on A in `values`, pin"),
    "start_counting": Array("i2", "joints, 6", "", "joints whose rows count from the start"),
    "start_constants": Array("f1", "n", "m or rad", "constants with which they vanish"),
    "start_map": Array("i2", "n, 6", "", "bodies that turn together, loops, given values that may count as exact"),
    "start_parts": Array("i1", "13", "", "first rows of its parts"),
    "start_turns": Array("f2", "n, bodies", "rad", "angles that are tried where none is given"),
    "start_bodies": Array("f2", "4, nb + 1", "rad", "angles that are known"),
    "start_spans": Array("f2", "n, 2", "m or 1", "spans of groups in loops, directions of slides"),
    "start_unknown": Array("f1", "n", "rad, m", "angles of groups and rods, slides; nan if not known"),
    "start_wishes": Array("i2", "3, n", "", "given values that do not count yet, that do; a way through nodes"),
    "start_nodes": Array("f2", "n, 5", "", "closings in the making"),
    "start_steps": Array("i2", "n, 5", "", "how each was made"),
    "start_heap": Array("i1", "n", "", "those that wait, the next first"),
    "start_search": Array("i1", "11", "", "counts of the search"),
    "start_found": Array("f2", "n, 3 nb", "m, rad", "positions that were found"),
    "start_judged": Array("f1", "11", "", "how far they are from given values"),
    # time integration
    "state": Array("f1", "ny", "SI", "y at clock[T], see `equations.state`"),
    "stepper": Array("i1", "6", "", "properties of the stepper of the run, see `step_state`"),
    "stepper_table": Array("i1", "2", "", "its kernels: step and dense output"),
    "rate": Array("f1", "ny", "SI/s", "its derivative"),
    "state_new": Array("f1", "ny", "SI", "the same at the end of a step"),
    "rate_new": Array("f1", "ny", "SI/s", ""),
    "stage": Array("f1", "ny", "SI", "state of one stage"),
    "slopes": Array("f2", "stages, ny", "SI/s", "derivatives at the stages"),
    "stage_times": Array("f1", "0 or stages", "", "c of an explicit method, see `solvers.tableau`"),
    "stage_weights": Array("f2", "0 or stages, stages", "", "a"),
    "end_weights": Array("f2", "0 to 3, stages of a step", "", "b, then weights of its error estimates"),
    "dense_weights": Array("f2", "rows, stages", "", "of the dense output above the cubic"),
    "stage_gaps": Array("f1", "0 to 3", "", "shares of the step at which no stage is near"),
    "dense": Array("f2", "7, ny", "SI", "coefficients of the dense output"),
    # implicit steppers, see `solvers.shifted_matrices`; n: rates of the bodies and states of elements
    "jacobian": Array("f2", "n, n + 3 nb", "", "of their derivatives by positions, rates and states"),
    "shifted": Array("f2", "n, n", "1/s", "real matrix of the iteration for the stages, factored"),
    "shifted_pair": Array("f2", "2 n, 2 n", "1/s", "complex one: real and imaginary parts, factored"),
    "shifted_order": Array("i1", "n", "", "rows exchanged in `shifted`"),
    "pair_order": Array("i1", "2 n", "", "rows exchanged in `shifted_pair`"),
    "newton": Array("f2", "19, ny or 2 n", "", "increments of the stages and their corrections"),
    "iteration": Array("f1", "10", "", "what is known of the iteration"),
    "clock": Array("f1", "11", "s", "of the run"),
    "passage": Array("f1", "13", "", "singular positions, see `singular_passage`"),
    "passages": Array("f2", "n, 4", "s", "singular positions that were passed"),
    "passage_states": Array("f2", "n, ny", "SI", "states there"),
    "passage_looks": Array("f2", "17, nr", "", "roots of every row in a step, scratch"),
    "passage_roots": Array("f1", "17", "", "scratch"),
    "peaks_aside": Array("f2", "quantities, 3", "SI", "largest values and mean squares before a singular position"),
    "tally": Array("i1", "13", "", "counts of the run"),
    "sign": Array("f1", "nw", "", "sign of every monitored force"),
    "crossings": Array("f2", "n, 3", "", "zero crossings of monitored forces"),
    "events": Array("f2", "n, 8", "SI", "what contacts did"),
    "break_rows": Array("f2", "0 or rows, columns", "SI", "output rows on both sides of events, see `solvers.breaks`"),
    "break_times": Array("f1", "0 or rows + 1", "s", "their number, then their times"),
    "measure": Array("f1", "nr", "1/m or 1/rad", "scale of every residual; negative for angles"),
    "audit": Array("f1", "22", "", "whether a step may stand, see `step_audit`"),
    "quantity": Array(
        "i2", "quantities, 2", "", "how a quantity with peaks is formed, and its first column after those of bodies"
    ),
    "peaks": Array("f2", "quantities, n", "SI", "largest values, mean squares and samples of the present step"),
    "sampling": Array("i1", "1", "", "what stages show of forces, see `peaks.samples`"),
    "sample_of_stage": Array("i1", "0 or stages of a step", "", "sample of each stage; -1: none"),
    "sample_order": Array("i2", "layouts, n", "", "samples in order of time"),
    "sample_shares": Array("f2", "layouts, n", "", "their shares of the step"),
    "sample_count": Array("i1", "layouts", "", "how many there are"),
    "sample_weights": Array("f2", "layouts, samples", "", "of the mean"),
    "sample_coarse": Array("f2", "layouts, samples", "", "of the mean, by another rule"),
    "shape_nodes": Array("i1", "0 or 6", "", "samples of the polynomial through stages, see `peaks.stage_polynomial`"),
    "shape_places": Array("f1", "0 or 6", "", "their shares of the step"),
    "shape_factors": Array("f1", "0 or 6", "", "their barycentric weights"),
    "shape_forms": Array("f2", "0 or 6, 6", "", "coefficients of the polynomials that are 1 at one of them"),
    "beside_nodes": Array("i1", "n", "", "samples at other stages"),
    "beside_places": Array("f1", "n", "", "their shares of the step"),
    "beside_products": Array("f1", "n", "", "products of their distances from the nodes"),
    "peak_row": Array("f1", "columns", "SI", "the columns of joints of an output row, scratch"),
    "port_work": Array(
        "f2", "0 or nj, 6", "J", "work of impulses on the bodies of every joint, if powers are asked for"
    ),
    "port_row": Array("f1", "0 or columns", "SI", "output row with the ports of a step of time stepping"),
    "wear_rate": Array("f2", "0 or nc, 2 bins", "W", "P |slip| in the bins of bush and pin, if wear is asked for"),
    "wear_last": Array("f2", "0 or nc, 2 bins", "W", "N |slip| at the last step"),
    "wear_work": Array("f2", "0 or nc, 2 bins", "J", "its integral over time"),
    "wear_load": Array("f2", "0 or rows, 4", "m, N*m, N*m, m", "loads under which they slide, see `wear_sum`"),
    "wear_load_last": Array("f2", "0 or nc, 4", "m/s", "their rates at the last step"),
    "wear_speed": Array("f1", "0 or nc", "m/s", "approach speeds of contacts that last from before the run"),
    "wear_count": Array("i2", "0 or nc, 3", "", "rows filled, steps in the present row, steps in a row"),
    # around the step loop, see `run_loop`
    "course": Array("f1", "12", "", "what is settled before the start, and the place in the run"),
    "driver_jump": Array("f2", "jumps, 6", "", "jumps of drivers in speed, in order of time, up to one at inf"),
    "driver_leap": Array("f2", "0 or drivers, 9", "", "what is known of their jumps, see `solvers.driver_jumps`"),
    "jolt_rows": Array("f2", "0 or 3, nr", "m/s or rad/s, N*s", "nu before and after a jolt, Lambda"),
    "jammed": Array("i1", "nc", "", "1 for contacts that were closed in the first jam"),
    # switches of expressions of time alone, see `language.instants`; instants [s]
    "timed": Array(
        "i2", "switches of time, 9", "", "where they are, and where their instants stand; nested ones first"
    ),
    "switchings": Array("f2", "n, 2", "s", "instant and side from there on, switch after switch"),
    "edges": Array("f1", "n + 2", "s", "start, instants of all switches, the first beyond the end; then inf"),
    "search": Array("f1", "6", "", "what is known of the search for them"),
    "halves": Array("f1", "128", "s", "ends of spans that wait to be looked at"),
    "span_stack": Array("f2", "depth, 4", "SI", "bounds of values and of their rates: scratch of expressions"),
    "signal_spans": Array("f2", "ns, 5", "SI", "the same of signals; 1 where the signal is needed"),
    "landing": Array("f1", "8", "", "of switches that depend on the state, see `state_switches`"),
}


PLACE = {name: place for place, name in enumerate(ARRAYS)}  # of an array in the table of a handle
FLOAT, INTEGER = np.dtype(np.float64), np.dtype(np.int64)
TYPES = {name: (FLOAT if array.kind[0] == "f" else INTEGER, int(array.kind[1])) for name, array in ARRAYS.items()}
WIDTHS = {name: at.width(name) for name in at.COLUMNS}  # of arrays with named columns
Shapes = tuple[tuple[str, tuple[int, ...]], ...]  # by name


class Layout(NamedTuple):
    """Where arrays of given shapes lie in one block of memory: those of floats, those of integers, then all others."""

    places: Mapping[str, tuple[int, tuple[int, ...]]]  # first number and shape of each
    size: int  # of the block
    floats: slice  # of the numbers that are given
    integers: slice
    table: np.ndarray  # (arrays, 3) of a handle, with places in bytes


@lru_cache(maxsize=64)
def _layout(shapes: Shapes, others: Shapes) -> Layout:
    places: dict[str, tuple[int, tuple[int, ...]]] = {}
    ends, size = [], 0
    parts = ([field for field in shapes if TYPES[field[0]][0] is kind] for kind in (FLOAT, INTEGER))
    for part in (*parts, others):
        for name, shape in part:
            places[name] = size, shape
            size += math.prod(shape)
        ends.append(size)
    table = np.zeros((len(ARRAYS), 3), np.int64)
    for name, (first, shape) in places.items():
        table[PLACE[name]] = 8 * first, shape[0], shape[-1]
    table.flags.writeable = False
    return Layout(places, size, slice(0, ends[0]), slice(ends[0], ends[1]), table)


class Image:
    """The numbers with which the arrays of a new workspace begin, in one block of memory.

    given: arrays of numbers.  others: shapes of those that begin with zeros.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], others: Shapes) -> None:
        _check(arrays)
        shapes = tuple((name, array.shape) for name, array in arrays.items())
        self.layout = _layout(shapes, others)
        self.block = np.zeros(self.layout.size)
        for kind, part in ((FLOAT, self.layout.floats), (INTEGER, self.layout.integers)):
            numbers = [array.ravel() for array in arrays.values() if array.dtype == kind]
            if numbers:
                np.concatenate(numbers, out=self.block[part].view(kind))

    def copied(self) -> Image:
        """One of the same arrays, whose numbers may be changed."""
        copy = object.__new__(Image)
        copy.layout, copy.block = self.layout, self.block.copy()
        return copy

    def array(self, name: str, block: np.ndarray) -> np.ndarray:
        """One of the arrays, in a block of memory; an empty one if there is none of this name."""
        kind, dimensions = TYPES[name]
        first, shape = self.layout.places.get(name, (0, (0,) * dimensions))
        return np.ndarray(shape, kind, block, 8 * first)


class Handle:
    """What machine code gets for a workspace: the place of a table, three numbers for every array.

    table (arrays, 3): address of the array, length, numbers in a row.
    """

    __slots__ = ("address", "arrays", "table")

    def __init__(self, table: np.ndarray, arrays: object) -> None:
        self.arrays = arrays  # live as long as their addresses
        self.table = table
        self.address = address_of(table)


class Workspace:
    """The arrays of one run: attributes in plain Python; in machine code the table of `handle`.

    arrays: those that are not in the image; a table of Python functions is a tuple.  A workspace is a copy of the block
    of its image, of which Python makes an array when it first asks for it.
    """

    def __init__(self, arrays: Mapping[str, Any], image: Image | None = None) -> None:
        _check(arrays)
        self.__dict__.update(arrays)
        self._image = image or Image({}, ())
        self._block = self._image.block.copy()
        self.handle: Handle | str = functions.IN_PYTHON
        if isinstance(self.joint_table, np.ndarray) and functions.jit_runs():
            table = self._image.layout.table.copy()
            table[:, 0] += address_of(self._block)
            for name, array in arrays.items():
                table[PLACE[name]] = address_of(array), array.shape[0], array.shape[-1]
            self.handle = Handle(table, (self._block, arrays))

    def put(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Put arrays of numbers in the place of those of the same names."""
        _check(arrays)
        self.__dict__.update(arrays)
        if isinstance(self.handle, Handle):
            for name, array in arrays.items():
                self.handle.table[PLACE[name]] = address_of(array), array.shape[0], array.shape[-1]
            self.handle.arrays = (self.handle.arrays, arrays)

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in ARRAYS:
            raise AttributeError(f"a workspace has no array {name}")
        array = self._image.array(name, self._block)
        setattr(self, name, array)
        return array


def _check(arrays: Mapping[str, Any]) -> None:
    """Raise TypeError for a name that is not declared, and for an array of another kind."""
    if unknown := set(arrays) - set(ARRAYS):
        raise TypeError(f"a workspace has no array {', '.join(sorted(unknown))}")
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray):  # a table of Python functions
            continue
        if (array.dtype, array.ndim) != TYPES[name] or not array.flags.c_contiguous:
            kind = ARRAYS[name].kind
            raise TypeError(f"array '{name}' is not a contiguous {kind}: {array.dtype}, {array.shape}")
        if array.size and array.shape[-1] < WIDTHS.get(name, 0):
            raise TypeError(f"array '{name}' has {array.shape[-1]} of its {WIDTHS[name]} columns")
