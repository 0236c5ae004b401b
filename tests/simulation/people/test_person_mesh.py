"""Person meshes: closed, symmetric, of the body's volume, and full at bent joints."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from pipeline.production.shots.skinning import Skin
from pipeline.simulation.face_units import EYE_TURN
from pipeline.simulation.people.body_frames import (
    FRAMES,
    PARENTS,
    frame_origins,
    frames_from_joints,
)
from pipeline.simulation.people.body_mesh import bare_arms, trousers
from pipeline.simulation.people.cloth_folds import SEAM
from pipeline.simulation.people.footwear import shoes
from pipeline.simulation.people.garments import FRONTS, SKIRT_HEM, fastenings, skirt
from pipeline.simulation.people.person_mesh import (
    MaterialLayer,
    layer_parts,
    person_layers,
)
from pipeline.simulation.people.proportions import (
    ADULT,
    CHILD,
    JOINTS,
    BodyMeasures,
    Proportions,
)
from pipeline.simulation.people.shirt_mesh import SHIRT_HEM, Sleeve, hem_rise, shirt, shirt_field
from pipeline.simulation.people.skinned_surface import symmetric_field
from pipeline.simulation.people.tints import PALE_SOCK, RUBBER, SHOE_TRIMS, SOCK
from pipeline.simulation.people.trims import cuffs
from pipeline.simulation.people.wardrobe import (
    BARE_LOOKING,
    OUTFITS,
    Clothes,
    Garment,
    Stature,
    deal_clothes,
)
from pipeline.simulation.spatial import Array, normalized, quaternion, rotation
from pipeline.simulation.take import Node
from pipeline.spec.costume import COSTUMES, Costume, HairStyle
from render.color import linear
from render.config import MATERIALS

DENSITY = 985.0
"""Density of a human body [kg/m³]."""

Z = np.array([0.0, 0.0, 1.0])

ALL = [
    (proportions, Clothes(style=style, build=build, shorts=short, short_sleeves=short))
    for proportions in (ADULT, CHILD)
    for style, build, short in [
        ("short", "medium", False),
        ("bob", "sturdy", True),
        ("bun", "slim", True),
        ("long", "slim", False),
        ("none", "sturdy", False),
    ]
]
NO_CREASES = np.zeros((0, 3), np.float32)

EVERYONE = pytest.mark.parametrize(("proportions", "clothes"), ALL)


def trimesh_of(layer: MaterialLayer) -> trimesh.Trimesh:
    mesh = layer.mesh
    return trimesh.Trimesh(mesh.vertices.astype(float), mesh.faces.astype(int), process=False)


def posed_vertices(
    proportions: Proportions, layers: tuple[MaterialLayer, ...], joints: Array
) -> list[Array]:
    """Return the vertices of all layers in a pose of joints."""
    R, p = frames_from_joints(joints)
    origins = frame_origins(proportions)
    nodes = [Node(n, "", -1, tuple(o)) for n, o in zip(FRAMES, origins.tolist(), strict=True)]
    meshes, parts = layer_parts("", layers, 0, 0, 1)
    take = SimpleNamespace(
        nodes=nodes,
        meshes=meshes,
        parts=parts,
        rotations=quaternion(R)[None],
        positions=p[None],
        scales=np.zeros((1, 0, 3)),
        scaled=(),
        alive=np.ones((1, len(FRAMES)), bool),
        faces=(),
        header=SimpleNamespace(rate=Fraction(24), samples=4),
    )
    skin = Skin.of(take)  # type: ignore[arg-type]
    places = skin.posed(take, 0).astype(float)  # type: ignore[arg-type]
    return [places[a:b] for a, b in zip(skin.starts[:-1], skin.starts[1:], strict=True)]


def test_every_clothing_option_occurs() -> None:
    tried = [clothes for _, clothes in ALL]
    assert {c.style for c in tried} == set(get_args(HairStyle))
    assert {c.build for c in tried} == set(get_args(Stature))


@EVERYONE
def test_all_layers_are_closed_and_face_outward(proportions: Proportions, clothes: Clothes) -> None:
    for layer in person_layers(proportions, clothes):
        edges = np.sort(layer.mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        _, counts = np.unique(edges, axis=0, return_counts=True)
        assert (counts == 2).all(), layer.name
        solid = trimesh_of(layer)
        assert solid.is_winding_consistent
        assert all(piece > 0 for piece in _volumes(solid)), layer.name
        assert layer.material in MATERIALS


def _volumes(solid: trimesh.Trimesh) -> list[float]:
    """Return the volumes of the closed pieces of a surface."""
    labels = trimesh.graph.connected_component_labels(solid.face_adjacency, len(solid.faces))
    a, b, c = (solid.triangles[:, k] for k in range(3))
    signed = (a * np.cross(b, c)).sum(axis=-1) / 6.0
    return [float(v) for v in np.bincount(labels, signed)]


@EVERYONE
def test_meshes_are_small_and_follow_adjacent_frames(
    proportions: Proportions, clothes: Clothes
) -> None:
    layers = person_layers(proportions, clothes)
    assert sum(len(layer.mesh.vertices) for layer in layers) < 12500
    beside = {(k, parent) for k, parent in enumerate(PARENTS)}
    for layer in layers:
        mesh = layer.mesh
        np.testing.assert_allclose(mesh.weights.sum(axis=1), 1.0, atol=1e-6)
        assert (mesh.weights >= 0).all()
        assert mesh.nodes.shape == mesh.weights.shape == (len(mesh.vertices), 2)
        for pair in {tuple(pair) for pair in mesh.nodes[mesh.weights[:, 1] > 0].tolist()}:
            assert pair[0] == pair[1] or pair in beside or pair[::-1] in beside
        # Vertices of a frame of one side lie on that side.
        names = np.array([f"{name:_>12}"[-2:] for name in FRAMES])[mesh.nodes[:, 0]]
        z = mesh.vertices[:, 2]
        assert (z[names == "_r"] > -1e-6).all()
        assert (z[names == "_l"] < 1e-6).all()


@EVERYONE
def test_meshes_are_symmetric(proportions: Proportions, clothes: Clothes) -> None:
    for layer in person_layers(proportions, clothes):
        places = layer.mesh.vertices.astype(float)
        other, mirror = cKDTree(places).query(places * [1.0, 1.0, -1.0])
        assert other.max() < 2e-6, layer.name
        np.testing.assert_allclose(layer.mesh.weights[mirror], layer.mesh.weights, atol=1e-4)


@EVERYONE
def test_vertices_in_the_middle_follow_no_side(proportions: Proportions, clothes: Clothes) -> None:
    sides = np.array([name[-2:] in ("_l", "_r") for name in FRAMES])
    for layer in person_layers(proportions, clothes):
        mesh = layer.mesh
        middle = np.abs(mesh.vertices[:, 2]) < 1e-6
        pulled = (sides[mesh.nodes] * mesh.weights).sum(axis=1)
        np.testing.assert_allclose(pulled[middle], 0.0, atol=1e-6)


@pytest.mark.nightly
@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
def test_volumes_match_the_body_mass(proportions: Proportions) -> None:
    """The volume of body and clothes is that of the body within a tenth."""
    layers = person_layers(proportions, Clothes(style="none"))
    bodies = [trimesh_of(layer) for layer in layers if layer.name not in ("eyes", "hair")]
    low = np.min([b.bounds[0] for b in bodies], axis=0)
    high = np.max([b.bounds[1] for b in bodies], axis=0)
    rng = np.random.default_rng(6)
    points = low + (high - low) * rng.random((2200, 3))
    inside = np.zeros(len(points), bool)
    for body in bodies:
        inside |= _winding(body, points) > 0.5
    volume = inside.mean() * float(np.prod(high - low))
    assert volume * DENSITY == pytest.approx(proportions.mass, rel=0.1)


def _winding(body: trimesh.Trimesh, points: Array) -> Array:
    """Return how often a surface winds around points.

    Source: van Oosterom and Strackee 1983.
    """
    total = np.zeros(len(points))
    box = body.bounds
    near = ((points >= box[0]) & (points <= box[1])).all(axis=1)
    for chosen in np.array_split(np.flatnonzero(near), 40):
        a, b, c = (body.triangles[None, :, k] - points[chosen, None] for k in range(3))
        n_a, n_b, n_c = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
        over = (a * np.cross(b, c)).sum(axis=-1)
        under = n_a * n_b * n_c + (a * b).sum(-1) * n_c
        under += (b * c).sum(-1) * n_a + (c * a).sum(-1) * n_b
        total[chosen] = np.arctan2(over, under).sum(axis=1) / (2 * np.pi)
    return total


@pytest.mark.slow
@pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
def test_trousers_stay_under_the_shirt(proportions: Proportions) -> None:
    for build, style in itertools.product(get_args(Stature), ("short", "bob")):
        clothes = Clothes(build=build, style=style)
        layers = {layer.name: layer for layer in person_layers(proportions, clothes)}
        shirt, trousers = (
            trimesh_of(layers["shirt"]),
            layers["trousers"].mesh.vertices.astype(float),
        )
        hem = shirt.vertices[:, 1].min()
        # Trousers emerge below the shirt, whose hem turns inward and runs up at the sides.
        covered = trousers[trousers[:, 1] > hem + 0.023 * proportions.height]
        assert len(covered) > 50
        assert (_winding(shirt, covered) > 0.5).all()


@pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
def test_shoulders_slope_down_from_the_neck(proportions: Proportions) -> None:
    build = BodyMeasures(proportions, 1.0)
    places = shirt(build, "cuffed").vertices
    g, height = build.girth, proportions.height
    tops = []
    for aside in (0.05 * g, build.shoulders - 0.02 * g, build.shoulders + 0.012 * g):
        near = np.abs(places[:, 2] - aside) < 0.006 * g
        tops.append(float(places[near, 1].max()))
    # The sleeve falls away outside of the joint as well.
    assert (-np.diff(tops) > 0.008 * height).all()


def test_long_hair_goes_with_a_bust_and_a_waist() -> None:
    def outline(proportions: Proportions, style: HairStyle) -> tuple[float, float]:
        """Return how far the chest reaches ahead, and half the width of the waist [m]."""
        build = BodyMeasures(proportions, 1.0, Clothes(style=style).is_curved)
        patch = shirt(build, "short")
        on_trunk = np.isin(patch.frames[:, 0], [FRAMES.index("pelvis"), FRAMES.index("chest")])
        x, y, z = patch.vertices[on_trunk].T
        chest = np.abs(y - build.level(0.73)) < 0.02 * proportions.height
        waist = np.abs(y - build.level(0.63)) < 0.02 * proportions.height
        return float(x[chest].max()), float(z[waist].max())

    (ahead, wide), (straight_ahead, straight_wide) = outline(ADULT, "bob"), outline(ADULT, "short")
    assert ahead > straight_ahead + 0.005 * ADULT.height
    assert wide < straight_wide - 0.005 * ADULT.height
    # Not of a child.
    assert outline(CHILD, "bob") == outline(CHILD, "short")


def test_cloth_creases_inside_a_bent_elbow_alone() -> None:
    layers = person_layers(ADULT, Clothes(short_sleeves=False))
    mesh = next(one.mesh for one in layers if one.name == "shirt")
    elbow = ADULT.rest()[JOINTS.index("elbow_r")]
    near = np.linalg.norm(mesh.vertices - elbow, axis=1) < 0.07
    moves = mesh.creases[near]
    outward = (moves * (mesh.vertices[near] - elbow)).sum(axis=1)
    ahead = mesh.vertices[near, 0] > elbow[0] + 0.02
    behind = mesh.vertices[near, 0] < elbow[0] - 0.02
    # Pressed in and bulging ahead, where it closes; behind the bone stands out.
    assert outward[ahead].min() < -1e-4 < 1e-4 < outward[ahead].max()
    assert outward[behind].min() > -1e-5
    far = np.abs(mesh.vertices[:, 1] - elbow[1]) > 0.12
    below = mesh.vertices[:, 1] < ADULT.height * ADULT.shoulder - 0.12
    assert not np.abs(mesh.creases[far & below]).max() > 1e-4


@pytest.mark.parametrize("sleeve", get_args(Sleeve))
@pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
def test_sleeves_end_in_hollow_bands_around_the_arm(
    proportions: Proportions, sleeve: Sleeve
) -> None:
    build = BodyMeasures(proportions, 1.0)
    band, arms = cuffs(build, sleeve), bare_arms(build, sleeve == "short")
    right = band.vertices[:, 2] > 0.0
    edge = band.vertices[right, 1].min()
    at_edge = right & (band.vertices[:, 1] < edge + 1e-6)
    near = np.abs(arms.vertices[:, 1] - edge) < 0.012 * proportions.height
    arm = arms.vertices[near & (arms.vertices[:, 2] > 0.0)]
    for axis, middle in ((0, float(arm[:, 0].mean())), (2, build.shoulders)):
        rim = np.abs(band.vertices[at_edge, axis] - middle).max()
        assert rim > np.abs(arm[:, axis] - middle).max() + 0.0015 * build.girth
    # One looks into the dark, up to where the sleeve is closed.
    inside = right & (band.shades < 0.3)
    assert band.vertices[inside, 1].min() > edge + 0.004 * proportions.height


def test_hems_have_seams() -> None:
    build = BodyMeasures(ADULT, 1.0)
    for patch, hem in (
        (shirt(build, "short"), SHIRT_HEM),
        (trousers(build, shorts=True), 0.330),
        (skirt(build), SKIRT_HEM),
    ):
        heights = patch.vertices[:, 1]
        if hem == SHIRT_HEM:
            # A free hem runs up and down.
            heights = heights - hem_rise(build, patch.vertices)
            assert np.ptp(patch.vertices[heights < build.level(hem) + 1e-3, 1]) > 0.006
        above = (heights - build.level(hem)) / (SEAM * build.girth)
        assert patch.shades[np.abs(above - 1.0) < 0.08].max() < 0.75
        assert patch.shades[np.abs(above - 0.5) < 0.4].max() > 0.95


def test_shoes_are_no_bare_feet() -> None:
    dealt = [alone("ann", seed, name) for name in COSTUMES for seed in range(40)]
    for look in dealt:
        assert look.shoes != "leather" or look.skin not in BARE_LOOKING
        shoe = linear(MATERIALS[look.shoes].color)
        for trim in SHOE_TRIMS.get(look.shoes, (RUBBER, PALE_SOCK)):
            assert np.abs(np.log((np.array(trim) + 0.01) / (shoe + 0.01))).max() > 0.3
    # Socks show below bare shins alone.
    build = BodyMeasures(ADULT, 1.0)
    bare, covered = (shoes(build, has_socks) for has_socks in (True, False))
    assert (bare.tints[:, 0] == SOCK).sum() > 0 == (covered.tints[:, 0] == SOCK).sum()
    assert bare.vertices[:, 1].max() > covered.vertices[:, 1].max()


def test_equal_clothes_share_meshes() -> None:
    one = person_layers(ADULT, Clothes(shirt="red cloth"))
    other = person_layers(ADULT, Clothes(shirt="blue cloth"))
    for a, b in zip(one, other, strict=True):
        assert a.mesh is b.mesh
        assert not a.mesh.vertices.flags.writeable
    assert [layer.material for layer in one] != [layer.material for layer in other]


def alone(name: str, seed: int, costume: Costume | None = None) -> Clothes:
    return deal_clothes({name: costume}, seed)[name]


def test_clothes_of_one_alone_depend_on_name_and_seed() -> None:
    looks = [alone("p0", seed) for seed in range(40)]
    assert looks == [alone("p0", seed) for seed in range(40)]
    assert alone("p0", 1) != alone("p1", 1)
    for word in ("skin", "hair", "shirt", "trousers", "shoes", "style", "build", "shorts"):
        assert len({getattr(look, word) for look in looks}) > 1
    for look in looks:
        assert {look.skin, look.hair, look.shirt, look.trousers, look.shoes} <= set(MATERIALS)


def test_ten_people_wear_ten_costumes_whatever_their_order() -> None:
    names = [f"p{k}" for k in range(10)]
    worn = deal_clothes(dict.fromkeys(names), 5)
    assert worn == deal_clothes(dict.fromkeys(names[::-1]), 5)
    kinds = {(look.garments, look.short_sleeves, look.shorts) for look in worn.values()}
    assert len(kinds) == len(COSTUMES)
    looks = deal_clothes(dict.fromkeys(f"p{k}" for k in range(40)), 5).values()
    assert len({(look.shirt, look.trousers, look.garments) for look in looks}) > 30


@pytest.mark.parametrize("seed", range(8))
def test_nobody_is_dealt_what_an_author_gave_another(seed: int) -> None:
    wishes: dict[str, Costume | None] = dict.fromkeys(f"p{k}" for k in range(10))
    worn = deal_clothes({**wishes, "p3": "coat", "p7": "suit"}, seed)
    assert worn["p3"].garments == ("coat",)
    assert worn["p7"].garments == ("suit",)
    kinds = {(look.garments, look.short_sleeves, look.shorts) for look in worn.values()}
    assert len(kinds) == len(COSTUMES)


def test_a_costume_can_be_asked_for() -> None:
    assert set(OUTFITS) == set(COSTUMES)
    assert alone("ann", 1, "coat").garments == ("coat",)
    dress = alone("ann", 1, "dress")
    assert dress.trousers == dress.shirt
    for name in COSTUMES:
        for seed in range(20):
            look = alone("ann", seed, name)
            materials = {look.shirt, look.trousers, look.shoes, look.iris, look.accent}
            assert materials <= set(MATERIALS)


@pytest.mark.parametrize("garment", get_args(Garment))
@pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
def test_garments_are_closed_and_symmetric(proportions: Proportions, garment: Garment) -> None:
    for layer in person_layers(proportions, Clothes(garments=(garment,))):
        mesh = trimesh_of(layer)
        assert mesh.is_watertight, layer.name
        assert mesh.volume > 0.0
        if layer.name == "shirt" and garment in FRONTS:
            # Its seam and its breast pocket are on one side.
            continue
        mirrored = mesh.vertices * [1.0, 1.0, -1.0]
        assert cKDTree(mesh.vertices).query(mirrored)[0].max() < 1e-4, layer.name


@pytest.mark.parametrize("garment", FRONTS)
@pytest.mark.parametrize("proportions", [ADULT, CHILD], ids=["adult", "child"])
def test_buttons_and_seams_lie_on_the_front_of_the_shirt(
    proportions: Proportions, garment: Garment
) -> None:
    build = BodyMeasures(proportions, 1.0)
    patch = fastenings(build, garment)
    away = symmetric_field(shirt_field(build))(patch.vertices) / build.girth
    # Panels reach into the shirt by three layers of cloth.
    assert -0.013 < away.min() < away.max() < 0.008
    assert (patch.vertices[:, 0] > 0.0).all()


def test_hair_grows_from_the_head_and_leaves_the_eyes_free() -> None:
    for style in get_args(HairStyle):
        layers = {one.name: one.mesh for one in person_layers(ADULT, Clothes(style=style))}
        hair = layers["hair"]
        length = np.linalg.norm(hair.hair, axis=-1)
        assert 0.0 < length.max() < 0.13
        turning = layers["eyes"].targets[:, 1] == EYE_TURN
        eyes = layers["eyes"].vertices[layers["eyes"].targets[turning, 0]]
        tips = hair.vertices + hair.hair
        ahead = tips[
            (tips[:, 0] > eyes[:, 0].mean()) & (np.abs(tips[:, 1] - eyes[:, 1].mean()) < 0.01)
        ]
        assert not len(ahead) or np.abs(ahead[:, 2]).min() > np.abs(eyes[:, 2]).max()


@pytest.mark.parametrize(
    ("layer", "joints", "way", "most"),
    [
        ("skin", ("shoulder", "elbow", "hand"), 1.0, 0.25),
        ("shirt", ("shoulder", "elbow", "hand"), 1.0, 0.25),
        ("trousers", ("hip", "knee", "foot"), -1.0, 0.25),
    ],
)
def test_a_limb_bent_by_140_degrees_keeps_its_girth(
    layer: str, joints: tuple[str, str, str], way: float, most: float
) -> None:
    """Behind the hinge the surface keeps its distance, and no vertex is inside."""
    clothes = Clothes(short_sleeves=layer == "skin")
    creased = person_layers(ADULT, clothes)
    layers = [replace(x, mesh=replace(x.mesh, creases=NO_CREASES)) for x in creased]
    number = next(k for k, one in enumerate(layers) if one.name == layer)
    rest = ADULT.rest()
    bent = rest.copy()
    _, hinge, tip = (JOINTS.index(f"{name}_r") for name in joints)
    turn = rotation(Z, way * np.radians(140))
    bent[tip] = rest[hinge] + turn @ (rest[tip] - rest[hinge])
    before = posed_vertices(ADULT, layers, rest)[number]
    after = posed_vertices(ADULT, layers, bent)[number]
    near = (np.abs(before[:, 1] - rest[hinge, 1]) < 0.05) & (before[:, 2] > 0.02)
    # The arm alone, without palm and other limbs.
    assert near.sum() > 20
    radius = np.linalg.norm((before - rest[hinge])[near][:, :2], axis=-1)
    now = np.linalg.norm((after - rest[hinge])[near][:, :2], axis=-1)
    np.testing.assert_allclose(now, radius, rtol=most, atol=0.004)
    # Creases press cloth in by a third of the radius at most.
    folded = posed_vertices(ADULT, creased, bent)[number]
    now = np.linalg.norm((folded - rest[hinge])[near][:, :2], axis=-1)
    np.testing.assert_allclose(now, radius, rtol=0.36, atol=0.004)
    closed = layers[number].mesh.faces.astype(int)
    volumes = [trimesh.Trimesh(places, closed, process=False).volume for places in (before, after)]
    assert volumes[1] == pytest.approx(volumes[0], rel=0.1)


def lifted(degrees: float) -> Array:
    """Return the joints of an adult whose straight arms are lifted aside."""
    rest = ADULT.rest()
    raised = rest.copy()
    for side, way in (("r", -1.0), ("l", 1.0)):
        turn = rotation(np.array([1.0, 0.0, 0.0]), way * np.radians(degrees))
        shoulder = rest[JOINTS.index(f"shoulder_{side}")]
        for name in ("elbow", "hand"):
            k = JOINTS.index(f"{name}_{side}")
            raised[k] = shoulder + turn @ (rest[k] - shoulder)
    return raised


@pytest.mark.parametrize(("degrees", "most"), [(0.0, 2.0), (120.0, 2.8), (150.0, 3.8)])
@pytest.mark.parametrize("short", [True, False])
def test_a_shirt_keeps_its_shape_where_arms_are_lifted(
    degrees: float, most: float, short: bool
) -> None:
    """Of the shape with arms half lifted; no cloth beside the shoulder is torn or crushed."""
    layers = person_layers(ADULT, Clothes(short_sleeves=short))
    number = next(k for k, one in enumerate(layers) if one.name == "shirt")
    half, posed = (
        posed_vertices(ADULT, layers, lifted(angle))[number] for angle in (60.0, degrees)
    )
    faces = layers[number].mesh.faces.astype(int)
    volumes = [trimesh.Trimesh(places, faces, process=False).volume for places in (half, posed)]
    assert volumes[1] == pytest.approx(volumes[0], rel=0.05)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    long = [np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=-1) for p in (half, posed)]
    assert np.quantile(long[1] / long[0], 0.999) < most
    assert np.quantile(long[1] / long[0], 0.001) > 0.2


def shirt_poses(*poses: Array) -> tuple[MaterialLayer, list[Array]]:
    """Return the shirt of an adult with long sleeves, and its vertices in poses of joints."""
    layers = person_layers(ADULT, Clothes(short_sleeves=False))
    number = next(k for k, one in enumerate(layers) if one.name == "shirt")
    return layers[number], [posed_vertices(ADULT, layers, joints)[number] for joints in poses]


def with_forearms(direction: tuple[float, float, float], upper: Array | None = None) -> Array:
    """Return the joints of an adult whose forearms point in a direction, mirrored on the left."""
    joints = (ADULT.rest() if upper is None else upper).copy()
    for side, way in (("r", 1.0), ("l", -1.0)):
        elbow, hand = (JOINTS.index(f"{name}_{side}") for name in ("elbow", "hand"))
        length = float(np.linalg.norm(joints[hand] - joints[elbow]))
        joints[hand] = joints[elbow] + length * normalized(np.array(direction) * [1.0, 1.0, way])
    return joints


def test_the_twist_of_an_arm_comes_about_along_its_length() -> None:
    """Upper arms hang; forearms turn from ahead to across the belly, by 90 degrees."""
    layer, (rest, ahead, across) = shirt_poses(
        ADULT.rest(), with_forearms((1.0, 0.0, 0.0)), with_forearms((0.0, 0.0, -1.0))
    )
    moved = np.linalg.norm(across - ahead, axis=-1)
    shoulder, elbow = (ADULT.rest()[JOINTS.index(f"{name}_r")] for name in ("shoulder", "elbow"))
    on_arm = (layer.mesh.nodes == FRAMES.index("upper_arm_r")).any(axis=1)
    below, above = shoulder[1] - rest[:, 1], rest[:, 1] - elbow[1]
    assert moved[on_arm & (below > 0.0) & (below < 0.08)].max() < 0.025
    assert moved[on_arm & (above > 0.06) & (above < 0.10)].max() > 0.045


def test_no_cloth_jumps_where_a_bent_arm_passes_straight_up() -> None:
    poses = [with_forearms((1.0, 1.0, 0.0), lifted(angle)) for angle in np.arange(168.0, 193.0, 3)]
    _, posed = shirt_poses(*poses)
    steps = [np.linalg.norm(b - a, axis=-1).max() for a, b in itertools.pairwise(posed)]
    # Three degrees at the end of an arm, and the turn of its hinge.
    assert max(steps) < 0.03


def test_a_shoulder_has_no_notch_beside_a_level_arm() -> None:
    _, (posed,) = shirt_poses(lifted(90.0))
    aside = np.arange(0.06, 0.34, 0.012)
    top = np.array([posed[np.abs(posed[:, 2] - z) < 0.012, 1].max() for z in aside])
    rim = np.minimum(np.maximum.accumulate(top), np.maximum.accumulate(top[::-1])[::-1])
    assert (rim - top).max() < 0.028


@pytest.mark.parametrize(
    ("layer", "limb", "way"),
    [("shirt", ("elbow", "hand"), 1.0), ("trousers", ("knee", "foot"), -1.0)],
)
def test_a_creased_limb_keeps_its_volume_and_is_smooth_outside(
    layer: str, limb: tuple[str, str], way: float
) -> None:
    layers = person_layers(ADULT, Clothes(short_sleeves=False))
    number = next(k for k, one in enumerate(layers) if one.name == layer)
    rest = ADULT.rest()
    bent = rest.copy()
    for side in "lr":
        hinge, tip = (JOINTS.index(f"{name}_{side}") for name in limb)
        bent[tip] = rest[hinge] + rotation(Z, way * np.radians(90)) @ (rest[tip] - rest[hinge])
    faces = layers[number].mesh.faces.astype(int)
    volumes = [
        trimesh.Trimesh(posed_vertices(ADULT, layers, joints)[number], faces, process=False).volume
        for joints in (rest, bent)
    ]
    assert volumes[1] == pytest.approx(volumes[0], rel=0.02)
    hinge = JOINTS.index(f"{limb[0]}_r")
    places, moves = layers[number].mesh.vertices.astype(float), layers[number].mesh.creases
    near = (np.abs(places - rest[hinge]) < [0.10, 0.06, 0.10]).all(axis=1)
    outside = near & (way * (places[:, 0] - rest[hinge, 0]) < -0.025)
    sides = near & (np.abs(places[:, 0] - rest[hinge, 0]) < 0.015)
    assert min(outside.sum(), sides.sum()) > 10
    size = np.linalg.norm(moves, axis=-1)
    assert size[outside].max() < 0.005 < size[sides].max()
