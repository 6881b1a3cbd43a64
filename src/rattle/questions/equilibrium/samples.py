"""How ensembles, sweeps and tolerances ask it of each sample."""

from rattle.studies.runs.analyses import over_times

ANALYSIS = over_times(lambda m, times: m.equilibrium(times), 200, at_rest=True)
