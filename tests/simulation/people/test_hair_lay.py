"""Hair of people's heads lies on the skull and leaves the forehead free."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest
from scipy.spatial import cKDTree

from pipeline.production.scenery.stones import icosphere
from pipeline.simulation.people.face_shape import face_field
from pipeline.simulation.people.hair_lay import ROUND, head_hair
from pipeline.simulation.people.head_mesh import (
    PARTING,
    TAPER,
    Head,
    before_hair_line,
    hair_patch,
    haired,
    head_skin,
    parted,
)
from pipeline.simulation.people.proportions import ADULT, CHILD, BodyMeasures
from pipeline.simulation.people.tints import BEARD, LIP
from pipeline.spec.costume import HairStyle

HEADS = [Head(BodyMeasures(proportions, 1.0)) for proportions in (ADULT, CHILD)]

GROWN = [style for style in get_args(HairStyle) if style != "none"]

EVERY_HEAD = pytest.mark.parametrize("head", HEADS, ids=["adult", "child"])


@pytest.mark.parametrize("style", ["short", "bob", "long"])
def test_hair_ends_near_the_skull_however_long_it_is(style: str) -> None:
    vertices, faces = icosphere(3)
    head: Any = SimpleNamespace(centre=np.zeros(3), size=0.24, face=HEADS[0].face)
    patch: Any = SimpleNamespace(vertices=ROUND * head.size * vertices, faces=faces)
    hair = head_hair(head, style, patch)
    upper = vertices[:, 1] > 0.5
    tips = np.linalg.norm((patch.vertices + hair)[upper], axis=-1) / head.size
    assert 0.9 * ROUND < tips.min()
    assert tips.max() < 1.2 * ROUND


@EVERY_HEAD
@pytest.mark.parametrize("style", GROWN)
@pytest.mark.parametrize("parting", [-1.0, 0.0, 1.0])
def test_no_hair_hangs_over_the_forehead(head: Head, style: str, parting: float) -> None:
    patch = hair_patch(head, style)
    tips = patch.vertices + head_hair(head, style, patch, parting)
    seen, ends = ((places - head.centre) / head.size for places in (patch.vertices, tips))
    before = before_hair_line(head.face, seen)
    upper = (seen[:, 1] > 0.22) & (before > -0.25)
    assert upper.sum() > 20
    over = before_hair_line(head.face, ends)[upper]
    assert over.max() < 0.09
    assert (over - before[upper])[before[upper] > -0.1].mean() < 0.02


@EVERY_HEAD
@pytest.mark.parametrize("style", GROWN)
def test_hair_grows_out_of_the_skin_at_its_line(head: Head, style: str) -> None:
    seen = (hair_patch(head, style).vertices - head.centre) / head.size
    away = face_field(head.face, with_lids=False)(seen)
    before = before_hair_line(head.face, seen)
    upper = seen[:, 1] > 0.2
    assert away[upper & (before > -0.04)].max() < TAPER + 0.03
    # Farther back it has its full volume.
    assert away[upper & (before < -0.25)].max() > (0.02 if style == "bun" else 0.045)


@EVERY_HEAD
@pytest.mark.parametrize("style", GROWN)
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_hair_lies_low_in_its_parting_and_high_beside_it(
    head: Head, style: str, side: float
) -> None:
    patch = hair_patch(head, style)
    before, after = (
        (places - head.centre) / head.size
        for places in (patch.vertices, parted(patch, head, style, side).vertices)
    )
    rise = np.linalg.norm(after, axis=-1) - np.linalg.norm(before, axis=-1)
    if style == "bun":
        assert not rise.any()
        return
    assert np.abs(rise).max() < 0.05
    top = (before[:, 1] > 0.40) & (before[:, 0] > 0.0)
    aside = side * before[:, 2]
    assert rise[top & (np.abs(aside - PARTING) < 0.04)].min() < -0.012
    assert rise[top & (aside < -0.04)].max() > 0.015
    mirrored = (parted(patch, head, style, -side).vertices - head.centre) / head.size
    assert cKDTree(mirrored * [1.0, 1.0, -1.0]).query(after)[0].max() < 1e-4


@EVERY_HEAD
def test_skin_is_as_dark_as_the_hair_behind_its_line_alone(head: Head) -> None:
    skin, grown = head_skin(head), haired(head_skin(head), head)
    seen = (skin.vertices - head.centre) / head.size
    before = before_hair_line(head.face, seen)
    is_hair = grown.tint[:, 0] == BEARD
    assert is_hair[(before < -0.06) & (seen[:, 1] > 0.1)].all()
    assert not is_hair[before > 0.01].any()
    assert np.array_equal(grown.tint[:, 0] == LIP, skin.tint[:, 0] == LIP)
