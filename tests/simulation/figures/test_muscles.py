"""Muscles, furrows and bristles of hides."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_skin import figure_skin
from pipeline.simulation.figures.hide.furrows import furrow_share, furrowed
from pipeline.simulation.figures.hide.lumps import ball, budgeted, union_distance
from pipeline.simulation.figures.hide.muscles import loin_hollows
from pipeline.simulation.figures.hide.stance import Stance
from pipeline.simulation.figures.hide.trunk import body_lumps, has_muscles, haunch_lumps
from pipeline.spec.figure import Figure as Words


def figure_of(name: str) -> Figure:
    text = Path(f"scenes/figures/{name}.yaml").read_text(encoding="utf-8")
    return build_figure(name, Words.model_validate(yaml.safe_load(text)["figure"]), 1.0)


def test_a_furrow_lies_where_two_balls_meet() -> None:
    lumps = [ball(np.array([x, 0.0, 0.0]), (1.0, 1.0, 1.0), 0.05) for x in (-0.8, 0.8)]
    solid = budgeted(lumps, 0.1, 20_000)
    share = furrow_share(lumps, solid, 1.0)
    x = np.abs(solid.vertices[:, 0])
    assert share[x < 0.05].mean() > 0.6
    assert share[x > 1.2].max() < 1e-9


def test_a_furrow_darkens_the_paint_that_there_is() -> None:
    lumps = [ball(np.array([x, 0.0, 0.0]), (1.0, 1.0, 1.0), 0.05) for x in (-0.8, 0.8)]
    solid = budgeted(lumps, 0.2, 20_000)
    white = np.ones((len(solid.vertices), 4))
    paint = furrowed(white.copy(), lumps, solid, 1.0)
    share = furrow_share(lumps, solid, 1.0)
    assert (paint[share > 0.5, :3] < 0.8).all()
    np.testing.assert_array_equal(paint[share == 0.0], white[share == 0.0])


@pytest.mark.parametrize(
    ("name", "shown"), [("dog", True), ("kangaroo", True), ("mouse", False), ("elephant", False)]
)
def test_legs_long_enough_show_muscles(name: str, shown: bool) -> None:
    assert has_muscles(Stance(figure_of(name))) is shown


def test_a_loin_is_narrower_than_shoulder_and_haunch() -> None:
    figure = figure_of("dog")
    stance = Stance(figure)
    trunk = list(body_lumps(figure, 0.5))
    lumps = [*trunk, *haunch_lumps(stance, trunk)]
    hips = [float(stance.chain(leg).points[0, 0]) for leg in figure.skeleton.legs]
    height = float(np.mean([stance.chain(leg).points[0, 1] for leg in figure.skeleton.legs]))

    def half_width(x: float) -> float:
        z = np.linspace(0.0, 0.5, 500)
        places = np.stack([np.full(500, x), np.full(500, height), z], axis=-1)
        return float(z[union_distance(lumps, places) < 0.0].max())

    loin = half_width(min(hips) + 0.4 * (max(hips) - min(hips)))
    assert loin < 0.85 * half_width(min(hips))
    assert loin < 0.90 * half_width(max(hips))


def test_hollows_of_the_loin_are_as_deep_as_asked_on_any_trunk() -> None:
    stance = Stance(figure_of("horse"))
    legs = [stance.chain(leg) for leg in stance.figure.skeleton.legs]
    hind = sorted(legs, key=lambda leg: float(leg.points[0, 0]))[:2]
    shoulder = max(float(leg.points[0, 0]) for leg in legs)
    trunk = [ball(np.zeros(3), (1.5, 0.4, 0.3), 0.1)]
    hollows = list(loin_hollows(trunk, hind, shoulder, 0.0))
    assert sorted(np.sign(lump.a[2]) for lump in hollows) == [-1.0, 1.0]
    for lump in hollows:
        assert lump.carved
        inner = lump.a - np.array([0.0, 0.0, np.sign(lump.a[2]) * lump.radii_a[2]])
        assert -0.16 * float(hind[0].radii[0]) - 0.02 < union_distance(trunk, inner[None])[0] < 0.0


def test_arthropods_have_bristles_where_their_figure_has_a_coat() -> None:
    def hairy(name: str) -> list[bool]:
        skins = figure_skin(figure_of(name)).skins.values()
        return [skin.hair is not None and bool(skin.hair.any()) for skin in skins]

    assert any(hairy("spider"))
    assert not any(hairy("ant"))


def test_a_scorpion_without_a_head_has_eyes_on_its_shield() -> None:
    paint = figure_skin(figure_of("scorpion")).skins[0].paint
    assert paint is not None
    black = (paint[:, 3] == 1.0) & (paint[:, :3].max(axis=-1) < 0.005)
    assert black.sum() > 100
