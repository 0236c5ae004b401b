"""Emitter choice: the sample of one emitter of many, by the light that each would give.

Mitsuba chooses an emitter blindly: of thirty lamps, most samples go to lamps that are too far away
to matter. Here several candidates, spread evenly over the emitters, are drawn as Mitsuba does, and
one of them is kept with a chance in proportion to the light that it sends to the surface if nothing
is in the way. That takes one shadow ray as before.

Source: J. Talbot, D. Cline, P. Egbert, Importance Resampling for Global Illumination, 2005.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.tracing.scene_pair import emitters_of

FEW = 3
"""Emitters up to which one is chosen blindly: sun, sky and a lamp."""

CANDIDATES = 16
"""Candidates of a sample, at most. Of 30 lamps at two samples a pixel, time times variance was 17
with a blind choice, 7.3 with 4 candidates, 5.4 with 8 and 3.8 with 16."""

_LEAST = 1e-6
"""Weight of a candidate without light, relative to 1: it must be possible if all have none."""


def emitter_sample(scene: Any, si: Any, u: Any, choice: Any, active: Any = True) -> tuple[Any, Any]:
    """Return a direction sample of an emitter, and its light divided by the chance of it.

    The density in the sample stays that of Mitsuba's blind choice, which weights for multiple
    importance sampling need: they may be of any densities that both techniques agree on.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        si: surfaces that are lit.
        u: pair of numbers for an emitter and a point on it.
        choice: number that chooses between candidates.
        active: which surfaces are lit.
    """
    emitters = len(emitters_of(scene).emitters())
    if emitters <= FEW:
        sample, light = scene.sample_emitter_direction(si, u, False, active)
        return sample, light
    count = min(emitters, CANDIDATES)
    kept, light = scene.sample_emitter_direction(si, _candidate(u, 0, count), False, active)
    total = _weight(si, kept, light)
    own = mi.Float(total)
    for i in range(1, count):
        other, its_light = scene.sample_emitter_direction(
            si, _candidate(u, i, count), False, active
        )
        weight = _weight(si, other, its_light)
        total += weight
        # Of what is left of the number, so that one is enough for all candidates.
        share = weight / total
        is_other = choice < share
        choice = dr.select(is_other, choice / share, (choice - share) / (1.0 - share))
        choice = dr.clip(choice, 0.0, 1.0)
        kept = dr.select(is_other, other, kept)
        light = dr.select(is_other, its_light, light)
        own = dr.select(is_other, weight, own)
    return kept, light * (total / (count * own))


def has_one_lamp(scene: Any) -> bool:
    """Return whether all samples of emitters go to the same one.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
    """
    return sum(lamp.sampling_weight() > 0.0 for lamp in emitters_of(scene).emitters()) == 1


def _candidate(u: Any, i: int, count: int) -> Any:
    """Return the numbers of the `i`-th candidate, one in each part of the emitters."""
    return mi.Point2f((u.x + i) / count, u.y)


def _weight(si: Any, sample: Any, light: Any) -> Any:
    """Return the light that a sample sends to a surface, and a little, to both of its sides."""
    facing = dr.abs(dr.dot(si.sh_frame.n, sample.d))
    bright = mi.luminance(light) * facing
    return dr.select(dr.isfinite(bright), dr.maximum(bright, 0.0), 0.0) + _LEAST
