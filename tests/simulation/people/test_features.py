"""Faces that differ by their features."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.simulation.people.body_mesh import bare_arms
from pipeline.simulation.people.features import GREATEST, Features, draw_features, with_features
from pipeline.simulation.people.head_mesh import Head, bearded, head_skin
from pipeline.simulation.people.proportions import ADULT, CHILD, BodyMeasures
from pipeline.simulation.people.tints import BEARD, BLUSH, LIP

HEAD = Head(BodyMeasures(ADULT, 1.0))


def seen(features: Features) -> np.ndarray:
    """Return the skin of a head with features, in heads."""
    patch = with_features(head_skin(HEAD), features, HEAD.centre, HEAD.size)
    return (patch.vertices - HEAD.centre) / HEAD.size


def test_no_features_leave_a_face_as_it_is() -> None:
    assert np.allclose(seen(Features()), (head_skin(HEAD).vertices - HEAD.centre) / HEAD.size)


@pytest.mark.parametrize("name", ["width", "jaw", "nose_length", "cheeks", "lips", "skew"])
def test_a_feature_moves_the_face_and_leaves_the_neck(name: str) -> None:
    mean, other = seen(Features()), seen(replace(Features(), **{name: 1.0}))
    moved = np.linalg.norm(other - mean, axis=-1)
    assert 0.004 < moved.max() < 0.05
    assert moved[mean[:, 1] < -0.58].max() < 1e-6


def test_a_wider_jaw_is_wider_at_the_jaw_alone() -> None:
    mean, other = seen(Features()), seen(Features(jaw=1.0))
    brow, jaw = (np.abs(mean[:, 1] - y) < 0.03 for y in (0.2, -0.3))
    assert np.ptp(other[jaw, 2]) > 1.03 * np.ptp(mean[jaw, 2])
    assert np.ptp(other[brow, 2]) == pytest.approx(np.ptp(mean[brow, 2]))


def test_features_differ_and_are_bounded() -> None:
    rng = np.random.default_rng(1)
    drawn = [draw_features(rng, True) for _ in range(40)]
    assert len(set(drawn)) == 40
    assert max(abs(f.jaw) for f in drawn) <= GREATEST
    assert 8 < sum(f.beard > 0.0 for f in drawn) < 30
    assert draw_features(rng, False).beard == 0.0


def test_lips_are_as_red_as_paint_with_a_bust_alone() -> None:
    shares = []
    for proportions, is_curved in ((ADULT, True), (CHILD, False), (ADULT, False)):
        tint = head_skin(Head(BodyMeasures(proportions, 1.0, is_curved))).tint
        shares.append(tint[tint[:, 0] == LIP, 1].max())
    assert shares[0] == pytest.approx(1.0)
    assert (-np.diff(shares) > 0.1).all()


def test_noses_cheeks_knuckles_and_elbows_are_flushed() -> None:
    skin = head_skin(HEAD)
    x, y, z = ((skin.vertices - HEAD.centre) / HEAD.size).T
    share = np.where(skin.tint[:, 0] == BLUSH, skin.tint[:, 1], 0.0)
    for place in ((0.4, -0.14, 0.0), (0.28, -0.13, 0.2)):
        near = np.linalg.norm(np.stack([x, y, np.abs(z)], axis=-1) - place, axis=-1) < 0.09
        assert share[near].max() > 0.6
    assert share[y > 0.25].max() < 0.1
    arms = bare_arms(HEAD.build, True)
    heights, share = arms.vertices[:, 1], arms.tint[:, 1]
    for level, least in ((0.433, 0.5), (0.632, 0.5)):
        near = np.abs(heights - HEAD.build.level(level)) < 0.015
        assert share[near].max() > least
        assert share[near].min() < 0.4
    assert share[np.abs(heights - HEAD.build.level(0.56)) < 0.01].max() < 0.1


def test_a_beard_covers_the_chin_and_leaves_lips_and_forehead() -> None:
    skin = head_skin(HEAD)
    grown = bearded(skin, HEAD, 0.8)
    y = ((skin.vertices - HEAD.centre) / HEAD.size)[:, 1]
    is_beard = grown.tint[:, 0] == BEARD
    assert is_beard.sum() > 100
    assert y[is_beard].max() < 0.0
    assert np.array_equal(grown.tint[:, 0] == LIP, skin.tint[:, 0] == LIP)
