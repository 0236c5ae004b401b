"""Start overlaps: performers that stand in one another in the first row.

Parents and hands, with all that goes with them, may overlap. So may different props, of which
authors build things, and limbs that are posed on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pipeline.simulation.members import Members
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.solid_overlaps import (
    TOLERANCE,
    PlacedSolid,
    assemblies,
    bent_parts,
    boxes_of,
    deepest_overlap,
    overlapping,
    solids_of,
)
from pipeline.simulation.take import TakeNote
from pipeline.spec.cast import Member
from pipeline.spec.group import Group
from pipeline.spec.prop import Prop


def overlap_notes(cast: Sequence[Member], members: Members, recorder: Recorder) -> list[TakeNote]:
    """Returns a note on each performer that begins inside of others.

    Args:
        cast: of the scene.
        members: of the cast, in the first row.
        recorder: the take, whose first row is written.
    """
    # The bodies of a group move by its rule.
    names = [member.name for member in cast if not isinstance(member, Group)]
    solids = {name: own for name in names if (own := solids_of(name, members, recorder))}
    assembly = assemblies(cast)
    props = {m.name: m.prop for m in cast if isinstance(m, Prop) and not m.may_fall}
    posed = {member.name for member in cast if getattr(member, "pose", ())}
    is_bent = bent_parts(recorder)
    found: dict[str, list[str]] = {}
    for one, other in _near_pairs(solids):
        joined = assembly.get(one, one) == assembly.get(other, other)
        is_placed = {one, other} <= props.keys() | posed and not {one, other} <= posed
        if joined or (is_placed and not _are_equal(props, solids, one, other)):
            continue
        depth = deepest_overlap(solids[one], solids[other], is_bent)
        if depth > 0.0:
            # It is rather the prop that stands where its author wants it.
            inner, outer = (other, one) if one in props else (one, other)
            found.setdefault(inner, []).append(f"{depth:.2g} m deep in '{outer}'")
    return [
        TakeNote("overlaps", 0, name, f"begins {' and '.join(texts)}; move one of them")
        for name, texts in found.items()
    ]


def _are_equal(
    props: Mapping[str, object], solids: Mapping[str, Sequence[PlacedSolid]], one: str, other: str
) -> bool:
    """Returns whether two props of equal shape stand in the same place."""
    if one not in props or other not in props or props[one] != props[other]:
        return False
    boxes = [boxes_of([solid.corners for solid in solids[name]]) for name in (one, other)]
    return float(np.abs(boxes[0] - boxes[1]).max()) < TOLERANCE


def _near_pairs(solids: Mapping[str, Sequence[PlacedSolid]]) -> Iterator[tuple[str, str]]:
    """Yields the performers whose bounding boxes overlap by more than the tolerance."""
    names = list(solids)
    boxes = boxes_of([np.concatenate([solid.corners for solid in own]) for own in solids.values()])
    for i, j in overlapping(boxes, boxes):
        if i < j:
            yield names[i], names[j]
