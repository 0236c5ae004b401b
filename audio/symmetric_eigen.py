"""Lowest solutions of K v = λ M v for symmetric matrices of a few hundred rows.

Everything but the products of small rows is elementwise: the bits do not depend on the number of
threads, and threads of a linear algebra library that wait for each other on busy processors take
a thousand times as long for such sizes.

Source: Golub and Van Loan 2013, 4.2.8 for the pivots, 8.3.1 for the tridiagonal form.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh_tridiagonal

from audio.dsp import Signal

# A direction with less than this share of its own mass is a sum of others.
_DEPENDENT = 1e-11


def lowest_eigenpairs(K: Signal, M: Signal, count: int) -> tuple[Signal, Signal]:
    """Return the lowest eigenvalues, ascending, and vectors of unit mass: (C,), (N, C).

    Directions of M that depend on others are left out.

    Args:
        K: (N, N) positive semidefinite.
        M: (N, N) positive semidefinite.
        count: C at most.
    """
    scale = 1 / np.sqrt(np.diag(M))
    L, order = _pivoted_cholesky(M * scale[:, None] * scale)
    scaled = (K * scale[:, None] * scale)[np.ix_(order, order)]
    reduced = _forward(L, _forward(L, scaled).T)
    values, vectors = _lowest(0.5 * (reduced + reduced.T), min(count, len(order)))
    result = np.zeros((len(K), values.size))
    result[order] = _backward(L, vectors) * scale[order, None]
    return values, result


def _pivoted_cholesky(M: Signal) -> tuple[Signal, Signal]:
    """Return L and the kept rows with M[rows][:, rows] = L L.T, for M of unit diagonal."""
    rest, n = M.copy(), len(M)
    columns = list[Signal]()
    order = list[int]()
    for _ in range(n):
        pivot = int(np.argmax(np.diag(rest)))
        if rest[pivot, pivot] <= _DEPENDENT:
            break
        column = rest[:, pivot] / np.sqrt(rest[pivot, pivot])
        # Rows already taken have nothing left.
        column[order] = 0.0
        rest -= column[:, None] * column
        rest[pivot, :] = rest[:, pivot] = 0.0
        columns.append(column)
        order.append(pivot)
    kept = np.array(order)
    return np.stack(columns, axis=1)[kept], kept


def _forward(L: Signal, right: Signal) -> Signal:
    """Return L⁻¹ right for a lower triangle L."""
    result = right.copy()
    for i in range(len(L)):
        result[i] /= L[i, i]
        result[i + 1 :] -= L[i + 1 :, i, None] * result[i]
    return result


def _backward(L: Signal, right: Signal) -> Signal:
    """Return L.T⁻¹ right for a lower triangle L."""
    result = right.copy()
    for i in range(len(L) - 1, -1, -1):
        result[i] /= L[i, i]
        result[:i] -= L[i, :i, None] * result[i]
    return result


def _lowest(A: Signal, count: int) -> tuple[Signal, Signal]:
    """Return the lowest eigenvalues and vectors of a symmetric matrix, by Householder's steps."""
    A, n = A.copy(), len(A)
    if n == 1:
        return A[0], np.ones((1, 1))
    mirrors = []
    beside = np.zeros(n - 1)
    for k in range(n - 2):
        x = A[k + 1 :, k].copy()
        length = float(np.sqrt((x * x).sum()))
        beside[k] = -length if x[0] > 0 else length
        x[0] -= beside[k]
        norm = float((x * x).sum())
        v = x * np.sqrt(2 / norm) if norm > 0 else np.zeros_like(x)
        rest = A[k + 1 :, k + 1 :]
        p = np.einsum("ij,j->i", rest, v)
        w = p - 0.5 * float((p * v).sum()) * v
        product = v[:, None] * w
        rest -= product + product.T
        mirrors.append(v)
    beside[-1] = A[-1, -2]
    values, vectors = eigh_tridiagonal(
        np.diag(A).copy(), beside, select="i", select_range=(0, count - 1)
    )
    for k in range(n - 3, -1, -1):
        v, part = mirrors[k], vectors[k + 1 :]
        part -= v[:, None] * np.einsum("i,ij->j", v, part)
    return values, vectors
