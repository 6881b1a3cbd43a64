"""Time integration: compiled, without state of its own, one call for many steps.

Arguments of one name mean the same in all modules.  m: workspace of a run.  t: time [s].  h: length of a step [s].
y: state, layout and units as in `equations.state`.  q, v: positions [m, rad] and rates [m/s, rad/s], (3 nb,).
theta, share, until: place in a step, 0 to 1.  n: number of a contact.  count: number of active contacts.
rtol, atol: tolerances of a step.  Shares and booleans have no unit; all other values are in SI units.
"""
