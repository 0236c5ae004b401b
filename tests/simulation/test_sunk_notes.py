"""Tests of notes on creatures of which something is in the ground."""

from __future__ import annotations

import pytest

from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

POSED = """
pronk: 1
duration: 1
cast:
  - figure: person
    pose: [{at: 0, body: {move: [0, %s, 0]}}]
"""


@pytest.mark.parametrize(("down", "expected"), [(0.0, False), (-1.2, True)])
def test_a_creature_in_the_ground_is_told_once_with_its_part(down: float, expected: bool) -> None:
    notes = [n for n in simulate(read_scene(POSED % down)).notes if n.kind == "passes_through"]
    assert len(notes) == expected
    for note in notes:
        assert note.part.startswith("person.")
        assert note.text.endswith("m deep in the ground")
