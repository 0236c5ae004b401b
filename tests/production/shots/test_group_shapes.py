"""Group shapes: rain is thin and clear, blades are narrow, and nothing moves otherwise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pipeline.production.shots.group_shapes import BLADE_WIDTH, DROP_SIDES, RAIN_DROP, drawn
from pipeline.production.shots.skinning import Skin
from pipeline.simulation.bodies.groups.member_meshes import RING_SIDES, drop
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene

RAIN = {"rule": "rain", "count": 12, "size": 0.2, "area": [2, 2], "height": 2, "speed": 6}
GRASS = {"rule": "grass", "count": 9, "size": 0.4, "area": [2, 2]}


def takes(group: dict[str, Any], **keys: Any) -> tuple[Take, Take]:
    """Return a take of one group, and as it is drawn."""
    member = {"name": "group", "group": group, "at": [0, 0], **keys}
    scene = Scene.model_validate(
        {
            "pronk": 1,
            "title": "Test",
            "duration": 0.5,
            "terrain": {"kind": "flat"},
            "cast": [member],
        }
    )
    take = simulate(scene)
    return take, drawn(take, scene)


def members(take: Take, row: int, count: int) -> np.ndarray[Any, np.dtype[np.floating[Any]]]:
    """Return the vertices (count, n, 3) of each member at a row of the take."""
    return np.asarray(Skin.of(take).posed(take, row)).reshape(count, -1, 3)


def test_falling_drops_are_narrow_streaks_and_splashes_are_crowns() -> None:
    before, after = takes(RAIN)
    row = len(before.positions) // 2
    thick, thin = (members(take, row, RAIN["count"]) for take in (before, after))
    tall = np.ptp(thick[..., 1], axis=1)
    falling, struck = tall > 0.15, (tall > 0.0) & (tall < 0.05)
    assert falling.any()
    assert struck.any()
    wide = [np.ptp(v[..., 0], axis=1)[falling].max() for v in (thick, thin)]
    assert wide[1] < 0.25 * wide[0]
    assert np.ptp(thin[..., 1], axis=1)[falling].max() < tall[falling].max()
    # A crown is a wall: no vertex of it lies near its middle.
    for one in thin[struck]:
        away = np.hypot(*(one[:-2, [0, 2]] - one[-1, [0, 2]]).T)
        assert away.min() > 0.6 * away.max()


def test_a_streak_has_the_vertices_of_a_drop() -> None:
    assert len(drop(0.2).vertices) == 4 * DROP_SIDES + 2
    assert RING_SIDES == DROP_SIDES


def test_drops_of_water_are_clear_and_others_are_as_the_author_wants() -> None:
    assert [part.material for part in takes(RAIN)[1].parts] == [RAIN_DROP]
    assert [part.material for part in takes(RAIN, material="steel")[1].parts] == ["steel"]


def test_blades_are_narrower_short_and_tall_and_up_to_as_high() -> None:
    before, after = takes(GRASS)
    wide, narrow = (members(take, 0, GRASS["count"]) for take in (before, after))
    assert np.ptp(narrow[..., 1]) == pytest.approx(np.ptp(wide[..., 1]), rel=0.05)
    # At the foot, where no blade leans yet.
    foot = wide[0, :, 1] < wide[0, :, 1].min() + 1e-4
    share = np.ptp(narrow[:, foot], axis=1)[:, [0, 2]] / np.ptp(wide[:, foot], axis=1)[:, [0, 2]]
    np.testing.assert_allclose(share, BLADE_WIDTH, atol=0.02)
    shares = np.ptp(narrow[..., 1], axis=1) / np.ptp(wide[..., 1], axis=1)
    assert shares.min() < 0.5
    assert 0.5 < shares.mean() < 0.8
    assert shares.max() < 1.05
    np.testing.assert_array_equal(after.positions, before.positions)


def test_other_groups_are_drawn_as_they_are() -> None:
    before, after = takes({"rule": "swarm", "count": 5})
    assert after is before
