"""Samples that run side by side, and the same samples one by one."""

import numpy as np
import pytest

from rattle.studies.runs.task import task_of

FINE = {"rtol": 1e-11, "atol": 1e-14}


def alone(m, samples, outputs, t_end, **options):
    """Outputs (outputs, n) of samples that run one by one."""
    task = task_of(m, list(samples), outputs, t_end=t_end, **options)
    return np.array(
        [task.run([values[i] for values in samples.values()]).outputs for i in range(len(next(iter(samples.values()))))]
    ).T


def side_by_side(m, samples, outputs, t_end, **options):
    """The answer, none of whose samples ran one by one; its values (outputs, n)."""
    found = m.many(samples, t_end=t_end, outputs=outputs, **options)
    assert not len(found.generic), found.stats["how"]
    return found, np.array([found[output] for output in outputs])


def assert_alike(m, samples, outputs, t_end, rel=1e-6, abs=1e-11, **options):
    options = options or FINE
    _, together = side_by_side(m, samples, outputs, t_end, **options)
    single = alone(m, samples, outputs, t_end, **options)
    for output, got, want in zip(outputs, together, single, strict=True):
        assert got == pytest.approx(want, rel=rel, abs=abs, nan_ok=True), output
