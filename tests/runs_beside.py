"""Derivatives as differences of runs at values beside."""

FINE = {"rtol": 1e-11, "atol": 1e-14}


def differences(m, name, of, t, step=1e-5):
    """Central differences of curves at instants; step: share of the parameter."""
    step *= abs(m.parameters[name]) or 1.0
    near = [m.set(**{name: m.parameters[name] + s}).simulate(t[-1], t_eval=t, **FINE) for s in (step, -step)]
    return {curve: (near[0][curve] - near[1][curve]) / (2 * step) for curve in of}
