"""Hand grips: hands close around props while they have them."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.attachment import Attachment, Grip
from pipeline.simulation.face_units import COLUMNS, hand_unit
from pipeline.simulation.hand_grips import CARRIED_GRIP, HandGrips
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import matrix
from pipeline.simulation.take import Take
from pipeline.spec import load_scene
from pipeline.spec.hold import TAKEN_GRIP
from pipeline.spec.scene_library import library


def test_hands_grip_what_they_hold_or_carry() -> None:
    grips = HandGrips([(3, 4), (8, 9)])
    own = np.array([0])
    grips.bind(
        [
            Attachment("cup", own, -1, (Grip(9, (5, 7)), Grip(9, (7, 8), 0.8))),
            Attachment("torch", own, 3, ()),
            Attachment("hat", own, 2, ()),
        ]
    )
    found = grips.at(4, 6)
    assert found.shape == (6, 2, 2)
    np.testing.assert_array_equal(found[:, 0], [[CARRIED_GRIP, 0.0]] * 6)
    np.testing.assert_array_equal(found[:, 1, 1], [0.0, TAKEN_GRIP, TAKEN_GRIP, 0.8, 0.0, 0.0])
    assert not found[:, 1, 0].any()


RADIUS, HEIGHT = 0.038, 0.10
"""Of the cup at the table [m]."""


def mouth_of(take: Take, row: int) -> np.ndarray:
    """Return (3,) where the lips of the guest are [m]."""
    skin = Skin.of(take)
    places, moved = skin.posed(take, row), list[np.ndarray]()
    for start, part in zip(skin.starts, visible_parts(take), strict=False):
        targets = take.meshes[part.seen].targets
        if part.performer == "guest" and len(targets):
            lips = targets[targets[:, 1] == COLUMNS.index("press"), 0]
            moved.append(places[start + lips])
    return np.concatenate(moved).mean(axis=0)


@pytest.mark.slow
def test_a_cup_stands_upright_in_the_hand_and_its_rim_comes_to_the_mouth() -> None:
    take = simulate(load_scene(library() / "at_the_table.yaml"))
    number = {node.name: k for k, node in enumerate(take.nodes)}
    per_second = take.header.samples * float(take.header.rate)
    cup, wrist = number["cup"], number["guest.arm_r1.3"]
    axes = matrix(take.rotations[:, cup])[..., 1]
    tilts = np.degrees(np.arccos(np.clip(axes[:, 1], -1.0, 1.0)))
    times = np.arange(len(tilts)) / per_second
    # Upright as it is taken and put down, and never on its side.
    assert tilts[(times < 3.5) | (times > 6.4)].max() < 12.0
    assert tilts.max() < 65.0
    row = round(5.0 * per_second)
    up = axes[row]
    angles = np.linspace(0.0, 2.0 * np.pi, 48)
    right = np.cross(up, [1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    ring = np.cos(angles)[:, None] * right + np.sin(angles)[:, None] * np.cross(up, right)
    rim = take.positions[row, cup] + 0.5 * HEIGHT * up + RADIUS * ring
    assert np.linalg.norm(rim - mouth_of(take, row), axis=1).min() < 0.025
    # The wrist lies beside the cup, and the fingers are closed around it.
    held = (times > 3.3) & (times < 6.7)
    offset = take.positions[held, wrist] - take.positions[held, cup]
    assert np.linalg.norm(offset, axis=1).min() > RADIUS + 0.02
    assert take.expressions[row, 0, hand_unit("grip", "r")] == pytest.approx(0.85, abs=0.02)
