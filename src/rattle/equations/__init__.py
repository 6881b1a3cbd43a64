"""The equations at one instant: constraints, forces, accelerations, contact problems.

Arguments of one name mean the same in all modules.  m: workspace of a run, arrays and units in `jit.workspace`.
t: time [s].  q, v: positions [m, rad] and rates [m/s, rad/s], (3 nb,).  y: state, see `equations.state`.
n: number of a contact.  k: number of an active contact.  count: number of active contacts.  All values in SI units.
"""
