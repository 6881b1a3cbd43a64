"""Dense linear algebra of small matrices in scalar loops: rank, null space, least squares, singular
values, linear equations.

    A^T P = Q R   by Householder reflections with pivoting, A (rows, n) stored by rows: row k is overwritten by
    column k of R above the diagonal, and by the reflection from there on

    H = U S V^T   by rotations of the columns of H that make them orthogonal (one-sided Jacobi)

    P A = L U     by elimination with partial pivoting, A (n, n)

Numbers are in the units of the caller.

Source: Golub, Van Loan, Matrix Computations (2013), sections 3.4, 5.4.2 and 8.6.3.
"""

from __future__ import annotations

import math

from rattle.jit.functions import compiled

SWEEPS = 30
FINE = 1e-15  # cosine between two columns that counts as a right angle


@compiled
def triangulate(wide, rows, order, pivot, share):
    """Reflections that make A^T triangular, in place; returns the rank.

    wide: A in its first rows (rows, n), then reflections and R; order (rows,): the permutation of the rows;
    pivot (2, rows): diagonal of R, and 2 / |v|^2 of every reflection; share: a row counts as dependent if its
    remainder is below this share of the longest row.
    """
    n = wide.shape[1]
    longest, rank = 0.0, 0
    for r in range(rows):
        order[r] = r
    for k in range(min(rows, n)):
        best, at = -1.0, k
        for r in range(k, rows):
            line = wide[r]
            square = 0.0
            for c in range(k, n):
                square += line[c] * line[c]
            if square > best:
                best = square
                at = r
        best = math.sqrt(max(best, 0.0))
        if k == 0:
            longest = best
        if not best > share * longest:
            break
        if at != k:
            order[k], order[at] = order[at], order[k]
            for c in range(n):
                wide[k, c], wide[at, c] = wide[at, c], wide[k, c]
        line = wide[k]
        pivot[0, k] = -math.copysign(best, line[k])
        pivot[1, k] = 1.0 / (best * (best + abs(line[k])))
        line[k] -= pivot[0, k]
        for r in range(k + 1, rows):
            reflect_once(line, pivot[1, k], k, wide[r])
        rank += 1
    return rank


@compiled
def reflect_once(line, factor, k, x):
    """Reflect x in the plane whose normal is in `line` from index k on."""
    dot = 0.0
    for c in range(k, x.shape[0]):
        dot += line[c] * x[c]
    dot *= factor
    for c in range(k, x.shape[0]):
        x[c] -= dot * line[c]


@compiled
def into_basis(wide, pivot, rank, x):
    """x = Q^T x, in place."""
    for k in range(rank):
        reflect_once(wide[k], pivot[1, k], k, x)


@compiled
def out_of_basis(wide, pivot, rank, x):
    """x = Q x, in place."""
    for n in range(rank):
        k = rank - 1 - n
        reflect_once(wide[k], pivot[1, k], k, x)


@compiled
def solve_upper(wide, pivot, rank, x):
    """x = R^-1 x for the first `rank` numbers, in place."""
    for n in range(rank):
        k = rank - 1 - n
        value = x[k]
        for j in range(k + 1, rank):
            value -= wide[j, k] * x[j]
        x[k] = value / pivot[0, k]


@compiled
def solve_lower(wide, pivot, rank, x):
    """x = R^-T x for the first `rank` numbers, in place."""
    for k in range(rank):
        value = x[k]
        for j in range(k):
            value -= wide[k, j] * x[j]
        x[k] = value / pivot[0, k]


@compiled
def rotate_columns(small, n):
    """Rotate the columns of a matrix H until they are orthogonal.

    small (2 k, k), k >= n: row j holds column j of H, then of U S; row k + j becomes column j of V.
    """
    half = small.shape[1]
    for i in range(n):
        for j in range(n):
            small[half + i, j] = 1.0 if i == j else 0.0
    for _ in range(SWEEPS):
        turned = False
        for i in range(n - 1):
            for j in range(i + 1, n):
                turned = rotate_pair(small[i], small[j], small[half + i], small[half + j], n) or turned
        if not turned:
            break


@compiled
def rotate_pair(first, other, v_first, v_other, n):
    """Make two columns orthogonal by a rotation, applied to those of V too; False if they are orthogonal already."""
    alpha, beta, gamma = 0.0, 0.0, 0.0
    for k in range(n):
        alpha += first[k] * first[k]
        beta += other[k] * other[k]
        gamma += first[k] * other[k]
    if not abs(gamma) > FINE * math.sqrt(alpha * beta):
        return False
    zeta = (beta - alpha) / (2.0 * gamma)
    tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
    c = 1.0 / math.sqrt(1.0 + tangent * tangent)
    s = c * tangent
    for k in range(n):
        x, y = first[k], other[k]
        first[k] = c * x - s * y
        other[k] = s * x + c * y
        x, y = v_first[k], v_other[k]
        v_first[k] = c * x - s * y
        v_other[k] = s * x + c * y
    return True


@compiled
def length(x, n):
    """Length of the first n numbers of a vector."""
    square = 0.0
    for k in range(n):
        square += x[k] * x[k]
    return math.sqrt(square)


@compiled
def solve_square(small, n, order, pivot, right, share, work, x):
    """x = H^-1 right; the component of a column of H that depends on the others is zero.

    small (k, k), k >= n: row j holds column j of H; overwritten.  order (k,), pivot (2, k), work (k,): scratch.
    """
    for k in range(n):
        work[k] = right[k]
        x[k] = 0.0
        for c in range(n, small.shape[1]):
            small[k, c] = 0.0
    rank = triangulate(small, n, order, pivot, share)
    into_basis(small, pivot, rank, work)
    solve_upper(small, pivot, rank, work)
    for k in range(rank):
        x[order[k]] = work[k]


@compiled
def solve_downhill(small, n, right, share, x):
    """x = |H|^-1 right for a symmetric H, small singular values raised to a share of the largest."""
    half = small.shape[1]
    largest = 0.0
    for j in range(n):
        largest = max(largest, length(small[j], n))
    for k in range(n):
        x[k] = 0.0
    for j in range(n):
        part = 0.0
        for k in range(n):
            part += small[half + j, k] * right[k]
        part /= max(length(small[j], n), share * largest + 1e-300)
        for k in range(n):
            x[k] += part * small[half + j, k]


@compiled
def factor_lu(a, order):
    """L and U of A in place of it (n, n); order (n,): row exchanged at each step. Returns False if A is singular."""
    n = order.shape[0]
    for k in range(n):
        best, at = abs(a[k, k]), k
        for r in range(k + 1, n):
            if abs(a[r, k]) > best:
                best, at = abs(a[r, k]), r
        if not best > 0.0:  # also if it is not a number
            return False
        order[k] = at
        if at != k:
            for c in range(n):
                a[k, c], a[at, c] = a[at, c], a[k, c]
        top = a[k]
        inverse = 1.0 / top[k]
        for r in range(k + 1, n):
            line = a[r]
            share = line[k] * inverse
            line[k] = share
            if share != 0.0:
                for c in range(k + 1, n):
                    line[c] -= share * top[c]
    return True


@compiled
def solve_lu(a, order, x):
    """Solve A x = x in place with the factors of `factor_lu`; only the first n numbers of x count."""
    n = order.shape[0]
    for k in range(n):
        if order[k] != k:
            x[k], x[order[k]] = x[order[k]], x[k]
    for r in range(n):
        line, value = a[r], x[r]
        for c in range(r):
            value -= line[c] * x[c]
        x[r] = value
    for r in range(n - 1, -1, -1):
        line, value = a[r], x[r]
        for c in range(r + 1, n):
            value -= line[c] * x[c]
        x[r] = value / line[r]
