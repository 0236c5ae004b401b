"""Hand grips: hands close around props while they have them."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.attachment import Attachment, Grip
from pipeline.simulation.hand_grips import CARRIED_GRIP, HandGrips
from pipeline.spec.hold import TAKEN_GRIP


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
