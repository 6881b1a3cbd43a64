"""How ensembles, sweeps and tolerances ask it of each sample."""

from rattle.studies.runs.analyses import over_times

ANALYSIS = over_times(lambda m, times: m.inverse_dynamics(times, strict=True), 2000)
