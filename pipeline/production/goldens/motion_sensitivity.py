"""Sensitivity: up to which step a scene's motion withstands differences of rounding.

Other processors round the last bit differently (1e-16). A scene that leaves its golden after a
shift of its start by a nanometre is chaotic: rounding would lead it elsewhere too, only later.
"""

from __future__ import annotations

from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_golden import golden_of
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene

SHIFT = 1e-9
"""Largest shift of a performer's start [m]: far above rounding, far below every tolerance."""

DIRECTIONS = 7
"""Neighbours in the cast are shifted by different parts of `SHIFT`, so that distances change."""

SAFETY = 0.75
"""Fraction of the time to the first difference during which poses are compared."""


def predictable_steps(scene: Scene, take: Take) -> int | None:
    """Return the step up to which the motion of `scene` is predictable; None for all of it.

    Args:
        scene: any.
        take: of that scene.
    """
    verdict = compare(golden_of(take, scene.title), simulate(shifted(scene)))
    return int(SAFETY * max(verdict.first.step, 0)) if verdict.first is not None else None


def shifted(scene: Scene) -> Scene:
    """Return `scene` with every performer's start shifted on the ground by up to `SHIFT`."""
    cast = []
    for i, member in enumerate(scene.cast):
        at = getattr(member, "at", None)
        if at:
            shift = SHIFT * (i % DIRECTIONS + 1) / DIRECTIONS * (1 if i % 2 else -1)
            # Two coordinates lie on the ground, of three the second is the height.
            moved = (at[0] + shift, *at[1:-1], at[-1] + shift)
            member = member.model_copy(update={"at": moved})
        cast.append(member)
    return scene.model_copy(update={"cast": tuple(cast)})
