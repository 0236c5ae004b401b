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


def ground_notes(
    cast: Sequence[Member], recorder: Recorder, clock: Clock, ground: Ground
) -> list[TakeNote]:
    """Returns notes on characters: steep steps of people, and who leaves the terrain.

    Each is told where it first happens.

    Args:
        cast: of the scene.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        ground: the terrain.
    """
    roots = {node.performer: i for i, node in reversed(list(enumerate(recorder.nodes)))}
    notes = []
    for member in cast:
        if not isinstance(member, Character):
            continue
        # Once a frame.
        p = recorder.positions[:: clock.samples, roots[member.name]]
        found = [_departure(p, ground), _steep_step(p, ground) if member.acts else None]
        notes += [
            TakeNote(kind, frame * clock.steps, member.name, text)
            for kind, frame, text in filter(None, found)
        ]
    return notes


def _departure(p: Array, ground: Ground) -> tuple[str, int, str] | None:
    """Returns kind, frame and text of the note on who leaves the terrain at places (F, 3) [m]."""
    is_outside = ~ground.field.inside(p[:, 0], p[:, 2])
    if is_outside[0] or not is_outside.any():
        return None
    text = "beyond it the ground goes on level; make it larger"
    return "leaves_terrain", int(is_outside.argmax()), text


def _steep_step(p: Array, ground: Ground) -> tuple[str, int, str] | None:
    """Returns kind, frame and text of the note on a steep step along places (F, 3) [m]."""
    leg = float(p[0, 1] - ground.height(p[0, 0], p[0, 2]))
    height = ground.height(p[:, 0], p[:, 2])
    found = _first_step(p[:, [0, 2]], height, HIGHEST_STEP * leg, STEP_LENGTH * leg)
    if found is None:
        return None
    frame, rise = found
    way = "up" if rise > 0.0 else "down"
    text = f"goes {way} a step of {abs(rise):.2g} m, and people walk on any ground"
    return "climbs", frame, f"{text}; lead the way around it"


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
