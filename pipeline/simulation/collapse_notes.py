"""Collapse notes: walls, pyramids and stacks that fall by themselves, which nobody asked for."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from pipeline.simulation.clock import Clock
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.take import TakeNote
from pipeline.simulation.terrain import Ground
from pipeline.spec.body import Many
from pipeline.spec.cast import Member
from pipeline.spec.prop import Prop

MAX_SECONDS = 2.0
"""Time within which something that cannot stand has fallen [s]."""

DROP = 0.25
"""Loss of height of a body that is a fall, in the height of the pile."""

LEVEL = 0.01
"""Unevenness of the ground on which things stand [m]."""


def collapse_notes(
    cast: Sequence[Member], recorder: Recorder, clock: Clock, ground: Ground
) -> list[TakeNote]:
    """Returns a note on each pile of bodies that falls soon though nobody has touched it.

    Args:
        cast: of the scene.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        ground: the terrain.
    """
    still = {member.name for member in cast if isinstance(member, Prop) and not member.may_fall}
    notes = []
    for member in cast:
        if not isinstance(member, Many) or not _stands(member):
            continue
        nodes = [i for i, node in enumerate(recorder.nodes) if node.performer == member.name]
        frame = _collapse(recorder, clock, nodes)
        if frame is None or _is_touched(recorder, member.name, nodes, still, frame * clock.steps):
            continue
        p = recorder.positions[0, nodes]
        rise = float(np.ptp(ground.height(p[:, 0], p[:, 2])))
        why = (
            f"the ground under it rises by {rise:.2g} m; let it stand where it is level"
            if rise > LEVEL
            else "it cannot stand; make it lower or wider"
        )
        text = f"falls by itself: {why}"
        notes.append(TakeNote("collapses", frame * clock.steps, member.name, text))
    return notes


def _stands(member: Many) -> bool:
    """Returns whether bodies are put on top of one another, at rest."""
    return member.many.layout in ("wall", "pyramid", "stack") and not any(member.velocity)


def _collapse(recorder: Recorder, clock: Clock, nodes: Sequence[int]) -> int | None:
    """Returns the frame in which a body has fallen that stood on others; None without."""
    last = math.ceil(MAX_SECONDS * clock.rate)
    heights = recorder.positions[: last * clock.samples : clock.samples, nodes, 1]
    fallen = (heights[0] - heights > DROP * np.ptp(heights[0])).any(axis=1)
    return int(fallen.argmax()) if fallen.any() and np.ptp(heights[0]) > 0.0 else None


def _is_touched(
    recorder: Recorder, name: str, nodes: Sequence[int], still: Collection[str], step: int
) -> bool:
    """Returns whether anything but the ground and still props touches a pile up to a step."""
    own = {recorder.nodes[i].name for i in nodes}
    below = {*own, *still, "terrain"}
    return any(
        contact.other.partition(".")[0] not in below
        if contact.performer == name
        else contact.other in own and contact.performer not in still
        for contact in recorder.contacts
        if contact.step <= step
    )
