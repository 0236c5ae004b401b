"""Hair of people's heads lies on the skull."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pipeline.production.scenery.stones import icosphere
from pipeline.simulation.people.hair_lay import ROUND, head_hair


@pytest.mark.parametrize("style", ["short", "bob", "long"])
def test_hair_ends_near_the_skull_however_long_it_is(style: str) -> None:
    vertices, faces = icosphere(3)
    head: Any = SimpleNamespace(centre=np.zeros(3), size=0.24)
    patch: Any = SimpleNamespace(vertices=ROUND * head.size * vertices, faces=faces)
    hair = head_hair(head, style, patch)
    upper = vertices[:, 1] > 0.5
    tips = np.linalg.norm((patch.vertices + hair)[upper], axis=-1) / head.size
    assert 0.9 * ROUND < tips.min()
    assert tips.max() < 1.2 * ROUND
