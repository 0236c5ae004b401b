"""Tests of notes on creatures of which something is in a prop or a body."""

from __future__ import annotations

import pytest

from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import TakeNote
from pipeline.spec import read_scene

REACHING = """
pronk: 1
duration: 1.5
cast:
  - {prop: {shape: box, size: [0.3, 0.3, 0.3]}, name: crate, at: %s}
  - figure: person
    name: p
    pose:
      - {at: 1, limb: arm_r, frame: world, reach: [0.35, 1.2, 0.4], avoid: []}
"""


def _told(place: str) -> list[TakeNote]:
    notes = simulate(read_scene(REACHING % place)).notes
    return [note for note in notes if "'crate'" in note.text and note.kind == "passes_through"]


@pytest.mark.parametrize(("place", "expected"), [("[0.35, 1.2, 0.4]", 1), ("[0.35, 1.2, 1.4]", 0)])
def test_a_hand_in_a_thing_is_told_once_with_its_part(place: str, expected: int) -> None:
    notes = _told(place)
    assert len(notes) == expected
    for note in notes:
        assert note.part.startswith("p.arm_r")
        assert note.text.endswith("m deep in 'crate'")
        assert 0.3 < note.step / 192 <= 1.05
