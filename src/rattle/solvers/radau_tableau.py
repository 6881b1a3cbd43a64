"""Coefficients of Radau IIA with three stages.

    A^-1 = T diag(REAL, [RE, -IM; IM, RE]) T^-1

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), table IV.5.6 and section IV.8.

The dense output is corrected at the shares INNER of the step, by a polynomial that vanishes at both ends.  The terms of
`dense_output` without the first are BASIS there, and SLOPE with the first are the derivatives of four.
"""

from __future__ import annotations

import math

import numpy as np

ROOT = math.sqrt(6.0)
C = np.array([(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0])
A = np.array([
    [(88.0 - 7.0 * ROOT) / 360.0, (296.0 - 169.0 * ROOT) / 1800.0, (-2.0 + 3.0 * ROOT) / 225.0],
    [(296.0 + 169.0 * ROOT) / 1800.0, (88.0 + 7.0 * ROOT) / 360.0, (-2.0 - 3.0 * ROOT) / 225.0],
    [(16.0 - ROOT) / 36.0, (16.0 + ROOT) / 36.0, 1.0 / 9.0],
])  # fmt: skip
E = np.array([-13.0 - 7.0 * ROOT, -13.0 + 7.0 * ROOT, -1.0]) / 3.0  # error estimate of order 3
REAL = 3.0 + 3.0 ** (2.0 / 3.0) - 3.0 ** (1.0 / 3.0)  # eigenvalues of A^-1
RE, IM = 3.0 + 0.5 * (3.0 ** (1.0 / 3.0) - 3.0 ** (2.0 / 3.0)), -0.5 * (3.0 ** (5.0 / 6.0) + 3.0 ** (7.0 / 6.0))
T = np.array([
    [0.09443876248897524, -0.14125529502095421, 0.03002919410514742],
    [0.25021312296533332, 0.20412935229379994, -0.38294211275726192],
    [1.0, 1.0, 0.0],
])  # fmt: skip
TI = np.array([
    [4.17871859155190428, 0.32768282076106237, 0.52337644549944951],
    [-4.17871859155190428, -0.32768282076106237, 0.47662355450055044],
    [0.50287263494578682, -2.57192694985560522, 0.59603920482822492],
])  # fmt: skip

INNER = 0.5 - 0.5 * np.cos(0.2 * math.pi * np.arange(1, 5))  # between those of Chebyshev at both ends
BASIS = np.array([[s * (1 - s), s**2 * (1 - s), s**2 * (1 - s) ** 2, s**3 * (1 - s) ** 2] for s in INNER])
SLOPE = np.array([[1.0, 1 - 2 * s, 2 * s - 3 * s**2, 2 * s * (1 - s) * (1 - 2 * s)] for s in INNER])
FIT = np.linalg.inv(BASIS)  # from corrections at INNER to those terms
