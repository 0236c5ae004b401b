"""Render meshes of figures: closed, attached to connected links, and without mass."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import trimesh
import yaml

from pipeline.production.goldens.motion_digest import motion_digest
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.figure_skin import FOOT_MAKERS, extremity_skins, figure_skin
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.skins import Skin
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import OWN, UNSEEN
from pipeline.spec import Scene, read_scene
from pipeline.spec.figure import Feet
from pipeline.spec.figure import Figure as Words

SHIPPED = sorted(Path("scenes/figures").glob("*.yaml"))


def figure_config(name: str, **more: object) -> Words:
    text = Path(f"scenes/figures/{name}.yaml").read_text(encoding="utf-8")
    return Words.model_validate({**yaml.safe_load(text)["figure"], **more})


def shipped(name: str, **more: object) -> Figure:
    return build_figure(name, figure_config(name, **more), 1.0)


def winding(skin: Skin, places: Array) -> Array:
    """Return how often a surface winds around places (n, 3).

    Source: van Oosterom and Strackee 1983.
    """
    corners = skin.vertices[skin.faces.astype(int)]
    a, b, c = (corners[None, :, k] - places[:, None] for k in range(3))
    n_a, n_b, n_c = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    over = (a * np.cross(b, c)).sum(axis=-1)
    under = n_a * n_b * n_c + (a * b).sum(-1) * n_c + (b * c).sum(-1) * n_a + (c * a).sum(-1) * n_b
    result: Array = np.arctan2(over, under).sum(axis=1) / (2 * np.pi)
    return result


def is_closed(skin: Skin) -> bool:
    """Return whether every edge is run through as often one way as the other."""
    faces = skin.faces.astype(np.int64)
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    count = len(skin.vertices)
    there, back = (np.sort(edges[:, k] * count + edges[:, 1 - k]) for k in (0, 1))
    return bool((there == back).all())


def scene(**more: object) -> Scene:
    figure = figure_config("beetle", **more).model_dump(exclude_none=True, mode="json")
    text = {
        "pronk": 1,
        "frames": 20,
        "terrain": "flat",
        "figures": {"bug": figure},
        "cast": [{"figure": "bug", "walk": {}}],
    }
    return read_scene(yaml.safe_dump(text, sort_keys=False))


@pytest.mark.sample(8)
@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_skins_are_closed_and_follow_connected_links(file: Path) -> None:
    # A dressed person has skins of its own (`tests/simulation/people/test_dressed_figure.py`).
    more = {"skin": {"form": "plain"}} if file.stem == "person" else {}
    figure = shipped(file.stem, **more)
    looks, skeleton = figure_skin(figure), figure.skeleton
    assert not looks.covered & set(looks.skins)
    joint_of = [link.joint for link in skeleton.links]
    above = {
        (i, joint_of.index(j))
        for i, link in enumerate(skeleton.links)
        for j in _above(figure, link.joint)
        if j in joint_of
    }
    for skin in looks.skins.values():
        judge = trimesh.Trimesh(skin.vertices, skin.faces.astype(int), process=False)
        assert is_closed(skin)
        assert judge.volume > 0
        assert (skin.share >= 0).all()
        assert (skin.share <= 1).all()
        for pair in {tuple(pair) for pair in skin.links[skin.share > 0].tolist()}:
            assert pair[0] == pair[1] or pair in above or pair[::-1] in above
    # The centre of every covered link is inside its skin. Ears and horns grow from the skull.
    for number in looks.covered:
        link = skeleton.links[figure.pieces[number].link]
        if link.kind in ("feeler", "horn"):
            continue
        middle = link.ends.mean(axis=0)[None]
        assert any(winding(skin, middle)[0] > 0.5 for skin in looks.skins.values())


@pytest.mark.parametrize("name", ["horse", "kangaroo", "beetle", "spider"])
def test_skins_are_symmetric(name: str) -> None:
    """Vertices midway between two legs follow neither."""
    figure = shipped(name)
    body = figure_skin(figure).skins[0]
    middle = np.abs(body.vertices[:, 2]) < 1e-9
    legs = [limb.links[0] for limb in figure.skeleton.legs]
    pulled = body.share * np.isin(body.links[:, 1], legs)
    np.testing.assert_allclose(pulled[middle], 0.0, atol=1e-6)


def _above(figure: Figure, joint: int) -> list[int]:
    """Return the parent joints of a joint up to the next that moves a link, and the body."""
    found, parents = list[int](), figure.skeleton.parents
    moving = {link.joint for link in figure.skeleton.links}
    while joint != BODY:
        joint = int(parents[joint])
        found.append(joint)
        if joint in moving:
            break
    return found


@pytest.mark.parametrize("feet", get_args(Feet))
def test_feet_and_jaws_have_no_mass(feet: Feet) -> None:
    plain = FigureMass(shipped("beetle", feet="plain", jaws=False)).at_rest
    shod = FigureMass(shipped("beetle", feet=feet, jaws=True)).at_rest
    assert plain.mass == shod.mass
    np.testing.assert_array_equal(plain.inertia, shod.inertia)
    assert set(FOOT_MAKERS) | {"plain"} == set(get_args(Feet))


def test_skins_do_not_affect_motion() -> None:
    takes = [
        simulate(scene(feet=feet, jaws=jaws)) for feet, jaws in (("plain", False), ("paws", True))
    ]
    assert motion_digest(takes[0]) == motion_digest(takes[1])
    assert takes[0].digest != takes[1].digest
    solids = [[take.meshes[part.mesh] for part in take.parts] for take in takes]
    for one, other in zip(*solids, strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)


def test_take_lists_the_look_of_every_part() -> None:
    take = simulate(scene(skin={"form": "plain"}))
    looks = [part.look for part in take.parts]
    assert OWN in looks
    assert UNSEEN in looks
    seen = [part.seen for part in take.parts if part.seen != UNSEEN]
    assert len(set(seen)) == len(seen)
    names = [node.name for node in take.nodes]
    for part in take.parts:
        if part.look < 0:
            continue
        mesh = take.meshes[part.look]
        assert mesh is not take.meshes[part.mesh]
        limb = part.name.rpartition(".")[0]
        owners = {names[i] for i in np.unique(mesh.nodes).tolist()}
        assert part.name == "bug.body" or all(owner.startswith(limb) for owner in owners)
        np.testing.assert_allclose(mesh.weights.sum(axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize("name", ["horse", "antelope", "camel", "kangaroo", "ostrich", "beetle"])
def test_soles_are_level_with_the_tip(name: str) -> None:
    """At rest the soles are as low as the sphere around the tip."""
    figure = shipped(name)
    skeleton = figure.skeleton
    X_BJ = JointTree.of(skeleton).pose(skeleton.preferred)
    feet = {limb.links[-1]: limb for limb in skeleton.legs}
    tried = 0
    for number, more in extremity_skins(figure):
        if number not in feet:
            continue
        link, radius = skeleton.links[number], skeleton.links[number].radii[1]
        X = X_BJ[link.joint]
        places = np.concatenate([skin.vertices for skin in more])
        placed = (places - skeleton.places[link.joint]) @ X[:3, :3].T + X[:3, 3]
        tip = X[:3, :3] @ (link.ends[1] - skeleton.places[link.joint]) + X[:3, 3]
        lowest = (tip - placed)[:, 1].max() / radius
        assert 0.6 < lowest < 1.02
        tried += 1
    assert tried == len(skeleton.legs)


def test_upright_heads_have_faces() -> None:
    """A face has a nose in front, ears at the sides and small eyes."""
    figure = shipped("person", skin={"form": "plain"})
    looks, pieces = figure_skin(figure), figure.pieces
    eyes = [i for i, piece in enumerate(pieces) if ".eye_" in piece.name]
    for i in eyes:
        extents = [np.ptp(v, axis=0) for v in (looks.skins[i].vertices, pieces[i].solid.vertices)]
        assert (extents[0] < 0.6 * extents[1]).all()
    (limb,) = (limb for limb in figure.skeleton.limbs if limb.kind == "head")
    head = next(i for i, piece in enumerate(pieces) if piece.link == limb.links[0])
    reach = looks.skins[head].vertices - limb.tip
    assert reach[:, 0].max() > 1.05 * limb.tip_radius
    assert reach[:, 2].max() > 1.02 * limb.tip_radius


def test_eyes_and_jaws_are_optional() -> None:
    assert any(".eye_" in piece.name for piece in shipped("beetle").pieces)
    assert not any(".eye_" in piece.name for piece in shipped("beetle", eyes=False).pieces)
    head = next(limb for limb in shipped("beetle").skeleton.limbs if limb.kind == "head")
    with_jaws = {number for number, _ in extremity_skins(shipped("beetle"))}
    assert head.links[-1] in with_jaws
    assert head.links[-1] not in {
        number for number, _ in extremity_skins(shipped("beetle", jaws=False))
    }
    assert head.links[-1] not in {number for number, _ in extremity_skins(shipped("horse"))}
