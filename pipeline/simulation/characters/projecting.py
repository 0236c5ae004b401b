"""Projecting: nodes are moved to where links have their lengths and middles are in the middle.

Each end of a link moves by its share of the inverse masses: the halves of Horswill 2008
conserve momentum for equal masses alone. The offset printed there, p_i - p_i, is p_i - p_j.

Source: Horswill 2008, "Kinematic constraints"; Jakobsen 2001.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.layout import Crowd
from pipeline.simulation.characters.limbs import settle, straighten
from pipeline.simulation.dynamics.compiled import Record, compiled

ENOUGH = 2e-3
"""Part of its length that a link may be off when no more is done."""

MOST = 40
"""Times that all links of a character are gone through, at most."""


@compiled
def project(crowd: Crowd, owner: Record) -> float:
    """Move the nodes of one character nearer to where its links have their lengths.

    Returns:
        How much the worst was off, as a part of its length.
    """
    first = owner.links[0]
    worst = 0.0
    for n in range(first, first + owner.links[1]):
        worst = max(worst, _link(crowd, n))
    first = owner.middles[0]
    for n in range(first, first + owner.middles[1]):
        worst = max(worst, _middle(crowd, n))
    first = owner.limbs[0]
    for n in range(first, first + owner.limbs[1]):
        straighten(crowd, crowd.limbs[n])
    return worst


@compiled
def finish(crowd: Crowd, owner: Record) -> None:
    """Go on with one character until nobody sees that its links are off; then set its joints."""
    for _ in range(MOST):
        if project(crowd, owner) <= ENOUGH:
            break
    first = owner.limbs[0]
    for n in range(first, first + owner.limbs[1]):
        settle(crowd, crowd.limbs[n])


@compiled
def hold(crowd: Crowd) -> None:
    """Bring together nodes that are held together: links of length zero."""
    for n in range(len(crowd.grips)):
        i, j = crowd.grips[n, 0], crowd.grips[n, 1]
        if i >= 0 and j >= 0 and crowd.give[i] + crowd.give[j] > 0.0:
            share = 1.0 / (crowd.give[i] + crowd.give[j])
            for k in range(3):
                apart = share * (crowd.p[i, k] - crowd.p[j, k])
                crowd.p[i, k] -= crowd.give[i] * apart
                crowd.p[j, k] += crowd.give[j] * apart


@compiled
def _link(crowd: Crowd, n: int) -> float:
    """Move the ends of a link; return how much it was off, as a part of its length."""
    p = crowd.p
    i, j = crowd.ends[n, 0], crowd.ends[n, 1]
    x, y, z = p[i, 0] - p[j, 0], p[i, 1] - p[j, 1], p[i, 2] - p[j, 2]
    squared = x * x + y * y + z * z
    least, most = crowd.reach[n, 0], crowd.reach[n, 1]
    w_i, w_j = crowd.give[i], crowd.give[j]
    if least * least <= squared <= most * most or w_i + w_j == 0.0 or squared == 0.0:
        return 0.0
    apart = math.sqrt(squared)
    wanted = least if apart < least else most
    share = (apart - wanted) / (apart * (w_i + w_j))
    a, b = share * w_i, share * w_j
    p[i, 0] -= a * x
    p[i, 1] -= a * y
    p[i, 2] -= a * z
    p[j, 0] += b * x
    p[j, 1] += b * y
    p[j, 2] += b * z
    # What only limits may be off a little more: nobody sees it.
    off = abs(apart - wanted) / wanted
    return off if least == most else 0.2 * off


@compiled
def _middle(crowd: Crowd, n: int) -> float:
    """Move three nodes so that one is in the middle of two; return how far it was."""
    p = crowd.p
    m, i, j = crowd.middles[n, 0], crowd.middles[n, 1], crowd.middles[n, 2]
    w_m, w_i, w_j = crowd.give[m], crowd.give[i], crowd.give[j]
    weight = w_m + 0.25 * (w_i + w_j)
    if weight == 0.0:
        return 0.0
    squared = 0.0
    for k in range(3):
        apart = p[m, k] - 0.5 * (p[i, k] + p[j, k])
        squared += apart * apart
        apart /= weight
        p[m, k] -= w_m * apart
        p[i, k] += 0.5 * w_i * apart
        p[j, k] += 0.5 * w_j * apart
    return math.sqrt(squared)
