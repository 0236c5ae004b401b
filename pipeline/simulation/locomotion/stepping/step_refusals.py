"""Step refusals: creatures whose legs cannot make the steps of their pace on level ground."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.tip_ik import solve_tips
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

STANCE = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Places of a stance that are tried, from its middle, in halves of its length."""

LEAST_LIFT = 0.25
"""Height to which each foot must rise in the middle of its stance, in step heights: less scuffs."""

MISS = 1e-4
"""Distance of foot from place that counts as a miss, in lengths of the leg."""


def refuse_missed_steps(herd: Herd, numbers: Sequence[int]) -> None:
    """Refuse creatures whose feet miss places that every step on level ground goes through.

    Args:
        herd: the creatures.
        numbers: their numbers in the scene's cast.

    Raises:
        SceneError: there are some; holds a problem of each.
    """
    if not len(herd.owner):
        return
    misses = _misses(herd)
    held = np.concatenate([pace.held for pace in herd.paces])
    problems = list[Problem]()
    for c in np.flatnonzero(herd.walks).tolist():
        walking = (herd.owner == c) & ~held
        bad = np.flatnonzero(walking & (misses > MISS * herd.legs.lengths))
        if not len(bad):
            continue
        names = ", ".join(f"'{herd.leg_names[leg]}'" for leg in bad)
        message = (
            f"{names} of '{herd.figures[c].name}' cannot make its steps: a foot would be "
            f"{misses[bad].max():.2g} m off; let their joints bend (limits_deg) or slide farther, "
            f"or draw a knee about halfway between hip and foot; or take `walk` away"
        )
        problems.append(Problem(f"cast[{numbers[c]}].walk", message))
    if problems:
        raise SceneError(problems)


def _misses(herd: Herd) -> Array:
    """Return the greatest distance (L,) of each foot from a place of its step [m]."""
    owner, (x, z) = herd.owner, herd.rest.T
    z = z + herd.lateral_offset[owner]
    ground = herd.foot_radius - herd.body_height[owner]
    half = 0.5 * herd.stride[owner] * (1.0 - herd.swings)
    goals = [np.stack([x + part * half, ground, z], axis=-1) for part in STANCE]
    goals.append(np.stack([x, ground + LEAST_LIFT * herd.step_height, z], axis=-1))
    result: Array = solve_tips(herd.legs, herd.chains, np.stack(goals)).residual.max(axis=0)
    return result
