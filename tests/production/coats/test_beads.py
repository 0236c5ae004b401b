"""Beads of rain: on smooth skins that are out in the rain, as domes that move with the skin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.coats.beads import AROUND, MATERIAL, Beads, holds_beads
from pipeline.production.shots.ground_weather import wetted
from pipeline.production.shots.skinning import Skin, visible_parts
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import read_scene
from render.config import MATERIALS, Weather

SCENE = """
pronk: 1
fps: 24
duration: 0.1
terrain: {kind: flat, size: [4, 4], cells: [4, 4], material: dry soil, scatter: none}
cast: [{name: bug, figure: beetle, at: [0, 0], scale: 0.15}]
"""
RAIN = Weather(rain=0.6)
WET = {name: wetted(material, RAIN) for name, material in MATERIALS.items()}


@pytest.fixture(scope="module")
def take() -> Take:
    return simulate(read_scene(SCENE))


def beads(take: Take, pixel: float, rain: float = 0.6) -> Beads | None:
    finest = np.full(len(visible_parts(take)), pixel)
    return Beads.of(take, WET, finest, rain, 3)


def test_beads_stand_on_the_skin_and_point_away_from_it(take: Take) -> None:
    made, skin = beads(take, 0.0005), Skin.of(take)
    assert made is not None
    vertices = skin.posed(take, 0.0)
    skins = np.split(vertices, skin.starts[1:-1])
    meshes = made.at(0.0, skins)
    assert sum(len(mesh.faces) for mesh in meshes) > 200
    for number, mesh in zip(made.films, meshes, strict=True):
        assert mesh.material == MATERIAL
        domes = mesh.vertices.reshape(-1, 2 * AROUND + 1, 3)
        corners = skins[number][made.films[number].corners]
        # Within a face and a dome of its corners.
        reach = np.ptp(corners, axis=1).max(axis=-1) + made.films[number].radius
        away = np.linalg.norm(domes[:, 0] - corners.mean(axis=1), axis=-1)
        assert (away < 2.0 * reach).all()
        # Their faces look outward, as their tops do.
        p = domes[:, 1 : AROUND + 1].astype(float)
        n = np.cross(p[:, 0] - domes[:, 0], p[:, 1] - domes[:, 0])
        tops = mesh.normals.reshape(domes.shape)[:, 0]
        assert ((n * tops).sum(axis=-1) > 0).all()


def test_no_beads_where_they_are_too_small_to_be_seen_or_no_rain_falls(take: Take) -> None:
    assert beads(take, 0.05) is None
    assert beads(take, 0.0005, rain=0.0) is None


def test_beads_are_larger_in_a_world_at_an_insects_size(take: Take) -> None:
    finest = np.full(len(visible_parts(take)), 0.0002)
    usual, large = (Beads.of(take, WET, finest, 0.6, 3, size) for size in (1.0, 3.0))
    assert usual is not None
    assert large is not None
    assert usual.films.keys() == large.films.keys()
    mean, larger = (
        np.concatenate([film.radius for film in made.films.values()]).mean()
        for made in (usual, large)
    )
    assert larger == pytest.approx(3.0 * mean, rel=0.1)


def test_hair_skin_eyes_and_glass_hold_no_beads(take: Take) -> None:
    mesh = take.meshes[visible_parts(take)[0].seen]
    assert holds_beads(mesh, WET["green chitin"], 0.6)
    hairy = replace(mesh, hair=np.zeros_like(mesh.vertices))
    assert not holds_beads(hairy, WET["green chitin"], 0.6)
    for name in ("skin", "eye", "glass", "fur", "grey hide"):
        assert not holds_beads(mesh, WET[name], 0.6)
