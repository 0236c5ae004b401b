"""Hides: budgets, their shape as a figure stands, and the refusal of bad words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.figure_skin import figure_skin, skin_form
from pipeline.simulation.figures.hide.animal import AnimalHide
from pipeline.simulation.figures.hide.eyes import EYE_ANGLES, EYE_AROUND, eyeball, eyelids
from pipeline.simulation.figures.hide.feet import foot_way, paw_lumps
from pipeline.simulation.figures.hide.head import NOSE_SUNK, Head
from pipeline.simulation.figures.hide.head_gear import ear_solid, lip_groove, nose_solid
from pipeline.simulation.figures.hide.lumps import (
    ball,
    cone,
    mesh_lumps,
    settled,
    union_distance,
)
from pipeline.simulation.figures.hide.shanks import shank_solid, tail_solid
from pipeline.simulation.figures.hide.sheets import HOOF_POINTS, HOOF_RINGS, hoof
from pipeline.simulation.figures.hide.skulls import SKULLS
from pipeline.simulation.figures.hide.stance import Stance
from pipeline.simulation.figures.hide.wing_cases import ShellPlan, wing_case
from pipeline.simulation.figures.solids import Solid
from pipeline.spec.figure import Figure as Words

MOST_TRIANGLES = 13_200

ANIMALS = ("horse", "camel", "dog", "cat", "elephant", "mouse", "frog", "lizard", "ostrich")
SHELLS = ("beetle", "ant", "spider", "scorpion", "centipede", "crab")

TABLE = {
    "style": "mammal",
    "nodes": {
        "muzzle": [0, -1.5],
        "poll": [0, -1.1],
        "chest": {"at": [0, -0.6], "radius": 0.3},
        "rump": {"at": [0, 0.6], "radius": 0.3},
        "knee1_l": [-0.5, -0.6],
        "foot1_l": [-1.0, -0.6],
        "knee2_l": [-0.5, 0.6],
        "foot2_l": [-1.0, 0.6],
    },
    "chains": [
        ["muzzle", "poll", "chest", "rump"],
        ["chest", "knee1_l", "foot1_l"],
        ["rump", "knee2_l", "foot2_l"],
    ],
    "then": [{"mirror": "x"}],
}


def words_of(name: str) -> dict[str, object]:
    text = Path(f"scenes/figures/{name}.yaml").read_text(encoding="utf-8")
    words: dict[str, object] = yaml.safe_load(text)["figure"]
    return words


def built(words: dict[str, object]) -> Figure:
    return build_figure("it", Words.model_validate(words), 1.0)


@pytest.mark.sample(5)
@pytest.mark.parametrize("name", [*ANIMALS, *SHELLS])
def test_a_hide_has_few_triangles(name: str) -> None:
    figure = built(words_of(name))
    looks = figure_skin(figure)
    assert skin_form(figure) == ("arthropod" if name in SHELLS else "animal")
    assert sum(len(skin.faces) for skin in looks.skins.values()) <= MOST_TRIANGLES


def test_a_drawing_without_words_gets_a_head_and_legs() -> None:
    figure = built(TABLE)
    assert skin_form(figure) == "animal"
    looks = figure_skin(figure)
    body = looks.skins[0]
    followed = set(np.unique(body.links).tolist())
    assert {limb.links[-1] for limb in figure.skeleton.legs} <= followed
    assert body.paint is not None
    assert len(looks.skins) == 3  # the hide and two eyes


def test_words_of_the_skin_change_no_mass() -> None:
    words = words_of("horse")
    with_skin = FigureMass(built(words)).at_rest
    nodes = {
        name: {k: v for k, v in node.items() if k not in ("width", "height", "lift")}
        for name, node in dict(words["nodes"]).items()  # type: ignore[call-overload]
    }
    bare = FigureMass(built({**words, "nodes": nodes, "skin": {"form": "plain"}})).at_rest
    assert with_skin.mass == bare.mass
    np.testing.assert_array_equal(with_skin.inertia, bare.inertia)


def test_a_surface_goes_to_the_creation_frame_and_back() -> None:
    """What follows one link comes back where that link stands."""
    figure = built(words_of("horse"))
    stance = Stance(figure)
    link = figure.skeleton.legs[0].links[-1]
    places = stance.placed(link, figure.skeleton.links[link].ends)
    links = np.full((2, 2), link)
    back = stance.unposed(places, links, np.zeros(2))
    np.testing.assert_allclose(back, figure.skeleton.links[link].ends, atol=1e-9)


def test_forelegs_look_straighter_than_theirbones() -> None:
    figure = built(words_of("horse"))
    stance = Stance(figure)
    assert len(stance.straight_legs) == 2
    for limb in stance.straight_legs:
        links = [figure.skeleton.links[i] for i in limb.links]
        bones = np.array(
            [stance.placed(i, link.ends[1]) for i, link in zip(limb.links, links, strict=True)]
        )
        seen = stance.chain(limb).points[1:]
        np.testing.assert_array_equal(seen[-2:], bones[-2:])
        # From elbow to fetlock the knee lies ahead of the line.
        off = [p[1, 0] - 0.5 * (p[0, 0] + p[2, 0]) for p in (seen, bones)]
        assert 0.0 < off[0] < 0.5 * off[1]


def test_feet_side_by_side_follow_their_own_legs() -> None:
    figure = built(words_of("elephant"))
    stance = Stance(figure)
    legs = [i for i, limb in enumerate(figure.skeleton.limbs) if limb.kind == "leg"]
    for i in legs:
        chain = stance.chains[i]
        around = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, -1, 0]])
        places = chain.points[-1] + chain.radii[-1] * around
        links, share = stance.follow(places, legs)
        np.testing.assert_array_equal(links[:, 1], chain.limb.links[-1])
        np.testing.assert_allclose(share, 1.0, atol=1e-6)


def test_a_trunk_grows_from_the_skull() -> None:
    figure = built(words_of("elephant"))
    hide = figure_skin(figure).skins[0]
    head = next(limb for limb in figure.skeleton.limbs if limb.kind == "head")
    trunk = next(
        limb for limb in figure.skeleton.limbs if limb.kind == "feeler" and limb.side == "m"
    )
    pairs = {tuple(pair) for pair in hide.links.tolist()}
    assert (head.links[-1], trunk.links[0]) in pairs
    assert (trunk.links[-2], trunk.links[-1]) in pairs


def test_a_foot_with_two_toes_is_long_with_claws_and_a_pad_without() -> None:
    figure = built(words_of("camel"))
    chain = Stance(figure).chain(figure.skeleton.legs[0])
    reach = [
        max(float(lump.b[0]) for lump in paw_lumps(chain, 2, np.ones(2), claws))
        for claws in (True, False)
    ]
    assert reach[0] > reach[1] + float(chain.radii[-1])


def test_lumps_are_meshed_to_their_radii() -> None:
    solid = mesh_lumps([ball(np.zeros(3), (0.5, 0.3, 0.2), 0.1)], 0.03)
    np.testing.assert_allclose(np.abs(solid.vertices).max(axis=0), [0.5, 0.3, 0.2], atol=0.02)


def test_a_mesh_is_settled_on_the_surface_of_its_lumps() -> None:
    """A limb three cells thick is stepped as a surface net leaves it."""
    limb = [cone(np.zeros(3), np.array([1.0, 0.4, 0.2]), (0.10, 0.08), (0.09, 0.07), 0.0)]
    net = mesh_lumps(limb, 0.06)
    off = [
        float(np.abs(union_distance(limb, solid.vertices)).max())
        for solid in (net, settled(net, limb, 0.06))
    ]
    assert off[1] < 0.25 * off[0]


def test_a_plain_tail_goes_on_to_a_tip() -> None:
    points, radii = np.array([[0.0, 0, 0], [-1, 0, 0], [-2, 0, 0]]), np.array([0.2, 0.15, 0.1])
    short, long = (tail_solid(points, radii, 0.0, beyond).vertices for beyond in (0.0, 0.5))
    assert -2.2 < short[:, 0].min() < -2.0
    assert -2.6 < long[:, 0].min() < -2.5
    near_tip = long[long[:, 0] < -2.45]
    assert np.ptp(near_tip[:, 2]) < 0.7 * 2 * radii[-1]


def test_the_edge_of_a_pupil_is_a_ring_of_the_eye() -> None:
    """A pupil that is no circle would have a ragged edge across the rings."""
    figure = built(words_of("frog"))
    stance = Stance(figure)
    limb = next(i for i, each in enumerate(figure.skeleton.limbs) if each.kind == "head")
    head = Head.of(stance.chains[limb], SKULLS["frog"], figure.skin)
    solid, paint = eyeball(head, 1.0, "#b08a1e")
    dark = np.all(paint[:, :3] < 0.003, axis=1)[: len(EYE_ANGLES) * EYE_AROUND]
    rings = dark.reshape(len(EYE_ANGLES), EYE_AROUND)
    assert rings[:3].all()
    assert not rings[3:].any()
    rim = solid.vertices[2 * EYE_AROUND : 3 * EYE_AROUND]
    spread = np.linalg.norm(rim - rim.mean(axis=0), axis=-1)
    assert spread.max() > 1.5 * spread.min()


def head_of(words: dict[str, object]) -> Head:
    figure = built(words)
    stance = Stance(figure)
    limb = next(i for i, each in enumerate(figure.skeleton.limbs) if each.kind == "head")
    return Head.of(stance.chains[limb], SKULLS[figure.skin.skull or "dog"], figure.skin)


@pytest.mark.parametrize("name", ["dog", "cat", "antelope", "kangaroo", "mouse"])
def test_a_bare_nose_lies_in_the_muzzle_and_has_two_nostrils(name: str) -> None:
    head = head_of(words_of(name))
    assert head.nose is not None
    depth = -float(union_distance(list(head.bones()), head.nose[None])[0])
    # Where lumps overlap their union is deeper than it says.
    assert 0.6 * NOSE_SUNK * head.nose_extent[0] < depth < 0.7 * head.nose_extent[0]
    made = nose_solid(head)
    assert made is not None
    solid, paint = made
    local = (solid.vertices - head.nose) @ head.axes.T / head.nose_extent
    holes = local[paint[:, 0] < 0.5 * paint[:, 0].max()]
    assert len(holes) >= 4
    assert (holes[:, 0] > 0.0).all()
    assert (np.abs(holes[:, 2]) > 0.1).all()
    assert (holes[:, 2] > 0).sum() == (holes[:, 2] < 0).sum()
    assert lip_groove(head) is not None


def test_lids_leave_an_almond_whose_upper_edge_hangs_lower() -> None:
    head = head_of(words_of("dog"))
    solid, rim = eyelids(head, 1.0)
    look = head.way(head.skull.look, 1.0)
    ways = (solid.vertices[:EYE_AROUND] - head.eye(1.0)) / head.eye_radius
    off = np.degrees(np.arccos(ways @ look / np.linalg.norm(ways, axis=-1)))
    above, below = off[0], off[EYE_AROUND // 2]
    corners = off[[EYE_AROUND // 4, 3 * EYE_AROUND // 4]]
    assert above < below < corners.min()
    assert rim[:EYE_AROUND].min() == 1.0
    assert rim[3 * EYE_AROUND : 5 * EYE_AROUND].max() == 0.0


@pytest.mark.parametrize(("pupil", "taller"), [("slit", True), ("bar", False)])
def test_a_figure_chooses_its_pupils(pupil: str, taller: bool) -> None:
    head = head_of({**words_of("dog"), "skin": {"skull": "dog", "pupil": pupil}})
    solid, _ = eyeball(head, 1.0, "#b08a1e")
    rim = solid.vertices[2 * EYE_AROUND : 3 * EYE_AROUND] - head.eye(1.0)
    size = np.linalg.norm(rim - rim.mean(axis=0), axis=-1)
    assert bool(size[0] > 2.0 * size[EYE_AROUND // 4]) is taller


def test_a_figure_chooses_its_whiskers() -> None:
    words = words_of("cat")
    counts = [
        sum(
            len(skin.faces)
            for skin in figure_skin(
                built({**words, "skin": {"skull": "cat", "whiskers": length}})
            ).skins.values()
        )
        for length in (0, 0.5)
    ]
    assert counts[0] < counts[1]


@pytest.mark.parametrize(("coat", "has_mane"), [("smooth", True), ("none", False)])
def test_a_smooth_coat_keeps_the_hair_of_the_mane(coat: str, has_mane: bool) -> None:
    words = words_of("horse")
    skin = {"skull": "horse", "mane": "hanging", "coat": coat}
    hide = AnimalHide(built({**words, "skin": skin}))
    solid = Solid(hide.stance.chains[0].points, np.array([[0, 1, 2]], dtype=np.uint32))
    assert hide.hair_lay.hair(solid, [0]) is None
    limb = next(i for i, each in enumerate(hide.figure.skeleton.limbs) if each.kind == "head")
    assert (hide.hair_lay.locks(solid, limb) is not None) is has_mane


def test_ears_have_hair_on_their_back_alone() -> None:
    figure = built(words_of("dog"))
    hide = AnimalHide(figure)
    assert hide.head is not None
    limb = next(i for i, each in enumerate(figure.skeleton.limbs) if each.kind == "feeler")
    solid, inner = ear_solid(hide.head, hide.stance.chains[limb], -1.0, figure.skin)
    hair = hide.hair_lay.ear(solid, inner)
    assert hair is not None
    length = np.linalg.norm(hair, axis=-1)
    assert length[inner > 0.9].max() < 1e-9
    assert 0.2 * hide.hair_lay.length < length[inner == 0.0].mean() < hide.hair_lay.length


def test_a_lump_has_its_own_color() -> None:
    lump = {"node": "rump", "at": [0, 0.9, 0], "radii": [0.5, 0.5, 0.5], "color": "#ff0000"}
    skin = figure_skin(built({**TABLE, "skin": {"lumps": [lump]}})).skins[0]
    assert skin.paint is not None
    red = (skin.paint[:, 3] > 0.9) & (skin.paint[:, 0] > 0.9) & (skin.paint[:, 1] < 0.1)
    centre = np.array([-0.6, 0.27, 0.0])
    assert 10 < red.sum() < 0.5 * len(red)
    assert np.linalg.norm(skin.vertices[red] - centre, axis=-1).max() < 0.3


def test_the_wing_cases_of_a_beetle_meet_at_its_seam() -> None:
    plan = ShellPlan(front=0.6, waist=0.15, rear=-1.3, rim=0.0, half_width=0.56, height=0.33)
    left, right = (wing_case(plan, side)[0].vertices for side in (-1.0, 1.0))
    np.testing.assert_allclose(left * [1, 1, -1], right, atol=1e-12)
    assert 0.0 < right[:-2, 2].min() < 0.01
    assert right[:, 2].max() == pytest.approx(0.56, rel=0.1)
    assert right[:, 1].max() == pytest.approx(0.33, rel=0.1)


@pytest.mark.parametrize(
    ("skin", "message"),
    [
        ({"skull": "hors"}, "horse"),
        ({"shell": "bee"}, "beetle"),
        ({"paint": [{"where": "bely", "color": "#ffffff"}]}, "belly"),
        ({"paint": [{"where": "belly", "color": "white"}]}, "pattern"),
        ({"lumps": [{"node": "chst"}]}, "chest"),
        ({"lumps": [{"node": "chest", "color": "white"}]}, "pattern"),
        ({"toes": 9}, "5"),
        ({"pupil": "slitt"}, "slit"),
        ({"whiskers": -1}, "0"),
    ],
)
def test_bad_words_are_refused(skin: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Words.model_validate({**TABLE, "skin": skin})


def test_hair_of_a_part_is_longer_there_alone() -> None:
    words = words_of("dog")
    layer = {"where": "back", "color": "#806040", "share": 0.0}
    lengths = []
    for factor in (1.0, 2.5):
        hide = AnimalHide(built({**words, "skin": {"paint": [{**layer, "hair": factor}]}}))
        solid = mesh_lumps([ball(np.zeros(3), (0.5, 0.3, 0.2), 0.1)], 0.05)
        hair = hide.hair_lay.hair(solid, [])
        assert hair is not None
        lengths.append(np.linalg.norm(hair, axis=-1))
    ratio = lengths[1] / lengths[0]
    assert ratio.max() == pytest.approx(2.5)
    assert ratio.min() == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["horse", "antelope"])
def test_pasterns_end_inside_their_hooves(name: str) -> None:
    hide = AnimalHide(built(words_of(name)))
    chain = next(c for c in hide.stance.chains if c.limb.kind == "leg")
    tip, r, ahead = chain.points[-1], float(chain.radii[-1]), foot_way(chain)
    slope = float(chain.ways[-1] @ ahead) / -float(chain.ways[-1][1])
    horn = hoof(tip, ahead, slope, r, 1).vertices
    shank = shank_solid(chain, len(chain.ways) - 2, np.ones((len(chain.points), 2)), "hooves")
    # The line down the middle of the front wall, from the coronet to the sole.
    wall = horn[: len(HOOF_RINGS) * HOOF_POINTS : HOOF_POINTS]
    low = shank.vertices[shank.vertices[:, 1] < wall[:, 1].max()]
    assert len(low) > 8
    front = np.interp(low[:, 1], wall[::-1, 1], wall[::-1] @ ahead)
    assert ((low @ ahead) - front).max() < 0.1 * r
    # The sole lies a little in the turf.
    assert -0.15 * r < horn[:, 1].min() - (tip[1] - r) < 0.0
