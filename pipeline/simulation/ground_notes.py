"""Ground notes: characters who walk over edges too high for their legs, or leave the terrain.

People look for no footholds: they walk on whatever is below them, also into pits and up walls.
Beyond the terrain its edge goes on level, so that nothing falls.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.clock import Clock
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TakeNote
from pipeline.simulation.terrain import Ground
from pipeline.spec.cast import Member
from pipeline.spec.character import Character

HIGHEST_STEP = 0.4
"""Height of a step that a person can take, in the height of the pelvis at the start."""

STEP_LENGTH = 0.5
"""Distance over the ground within which it is a step, in the same height."""


def steep_step_notes(
    cast: Sequence[Member], recorder: Recorder, clock: Clock, ground: Ground
) -> list[TakeNote]:
    """Returns a note on each person who walks over an edge, where that first happens.

    Args:
        cast: of the scene.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        ground: the terrain.
    """
    people = [member.name for member in cast if isinstance(member, Character) and member.acts]
    roots = {node.performer: i for i, node in reversed(list(enumerate(recorder.nodes)))}
    notes = []
    for name in people:
        # Once a frame.
        p = recorder.positions[:: clock.samples, roots[name]]
        leg = float(p[0, 1] - ground.height(p[0, 0], p[0, 2]))
        height = ground.height(p[:, 0], p[:, 2])
        found = _first_step(p[:, [0, 2]], height, HIGHEST_STEP * leg, STEP_LENGTH * leg)
        if found is not None:
            frame, rise = found
            text = (
                f"goes {'up' if rise > 0.0 else 'down'} a step of {abs(rise):.2g} m, and people "
                "walk on any ground; lead the way around it"
            )
            notes.append(TakeNote("climbs", frame * clock.steps, name, text))
    return notes


def departure_notes(
    cast: Sequence[Member], recorder: Recorder, clock: Clock, ground: Ground
) -> list[TakeNote]:
    """Returns a note on each character that leaves the terrain, where that first happens.

    Args:
        cast: of the scene.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        ground: the terrain.
    """
    roots = {node.performer: i for i, node in reversed(list(enumerate(recorder.nodes)))}
    notes = []
    for name in (member.name for member in cast if isinstance(member, Character)):
        # Once a frame.
        x, _, z = recorder.positions[:: clock.samples, roots[name]].T
        is_outside = ~ground.field.inside(x, z)
        if is_outside.any() and not is_outside[0]:
            text = "beyond it the ground goes on level; make it larger"
            step = int(is_outside.argmax()) * clock.steps
            notes.append(TakeNote("leaves_terrain", step, name, text))
    return notes


def _first_step(
    places: Array, height: Array, highest: float, length: float
) -> tuple[int, float] | None:
    """Returns frame and rise [m] of the first step that is too high; None without.

    Args:
        places: (F, 2) over the ground [m].
        height: (F,) of the ground there [m].
        highest: step that can be taken [m].
        length: of a step [m].
    """
    along = np.concatenate([[0.0], np.linalg.norm(np.diff(places, axis=0), axis=-1).cumsum()])
    first = 0
    for frame in range(len(places)):
        while along[frame] - along[first] > length:
            first += 1
        rises = height[frame] - height[first : frame + 1]
        most = int(np.abs(rises).argmax())
        if abs(rises[most]) > highest:
            return frame, float(rises[most])
    return None
