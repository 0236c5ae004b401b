"""Surfaces: energy, agreement of the variants, patterns without streaks."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from render.config import MATERIALS, Film, Material, light, material
from render.footprints import BLOCK, FootprintRaster, pack_texels
from render.ground_wear import TEXELS, GroundWear
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Shot

Make = Callable[..., Shot]

ABOVE = CameraPose((0.0, 9.0, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0))
FILM = Film(size=(64, 64), samples=16, depth=2, denoise="off")

SHINING = {name for name, config in MATERIALS.items() if config.glow > 0}
SOME = ("dry soil", "mud", "snow", "walnut", "brass", "white fur", "glass", "green chitin")


def furnace(config: Material, ground: bool) -> float:
    """Return the mean radiance of a ball in a sky of radiance 1."""
    import mitsuba as mi

    from render.meshes import build_mesh, group_meshes

    solid = trimesh.creation.icosphere(subdivisions=4)
    place = solid.vertices.astype(np.float32)
    laid: dict[str, Any] = {"uv": place[:, [0, 2]].copy()} if ground else {"rest": place}
    mesh = Mesh("ball", place, solid.faces.astype(np.uint32), "m", **laid)
    (group,) = group_meshes([mesh], {"m": config})
    eye = mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": 24, "height": 24, "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": 18, "to_world": eye, "film": film}
    sky = {"type": "constant"}
    scene = {
        "type": "scene",
        "ball": build_mesh(group, [mesh], config),
        "sky": sky,
        "camera": camera,
    }
    path = mi.load_dict({"type": "path", "max_depth": 12, "rr_depth": 20})
    image = np.array(path.render(mi.load_dict(scene), spp=64))
    return float(image.max(axis=2).mean())


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name in SOME else [pytest.mark.nightly])
        for name in sorted(set(MATERIALS) - SHINING)
    ],
)
def test_no_material_gains_energy(renderer: Renderer, name: str) -> None:
    del renderer
    config = MATERIALS[name]
    assert furnace(config, ground=config.steep_color is not None) < 1.02


def test_a_diffuse_surface_reflects_its_albedo(renderer: Renderer) -> None:
    """Flat ground of a pattern in a furnace: the mean is that of the packed colours."""
    del renderer
    import mitsuba as mi

    from render.surfaces.bsdf_plugins import diffuse_bsdf
    from render.surfaces.patterns import GroundShader

    config = material({"preset": "dry soil", "bump": 0})
    look = GroundShader(config)
    surface = diffuse_bsdf(look, look.values)
    si: Any = mi.SurfaceInteraction3f()
    x, z = np.random.default_rng(4).uniform(-300, 300, (2, 100_000))
    si.p = mi.Point3f(x, 0 * x, z)
    si.n = mi.Normal3f(0, 1, 0)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 1, 0))
    si.t = mi.Float(1.0)
    si.wi = mi.Vector3f(0, 0, 1)
    ctx = mi.BSDFContext()
    u = mi.Point2f(*np.random.default_rng(5).random((2, 100_000)))
    found, weight = surface.sample(ctx, si, mi.Float(0.5), u)
    value, pdf = surface.eval_pdf(ctx, si, found.wo)
    np.testing.assert_allclose(np.array(value / pdf), np.array(weight), rtol=1e-4)
    np.testing.assert_allclose(np.array(pdf), np.array(found.pdf), rtol=1e-4)
    color, _ = look(si)
    np.testing.assert_allclose(np.array(weight), np.array(color), rtol=1e-5)
    density = mi.warp.square_to_cosine_hemisphere_pdf(found.wo)
    np.testing.assert_allclose(np.array(pdf), np.array(density), rtol=1e-4)


def test_sampling_matches_evaluation_with_bent_normals(renderer: Renderer) -> None:
    """Chi-square in short: the mean of value / pdf over samples is that over the hemisphere."""
    del renderer
    import drjit as dr
    import mitsuba as mi

    from render.surfaces.bsdf_plugins import diffuse_bsdf, glossy_bsdf

    tilted = mi.Normal3f(*(np.array([0.35, 0.0, 1.0]) / np.hypot(0.35, 1.0)).tolist())

    def look(si: Any) -> tuple[Any, Any]:
        del si
        return mi.Color3f(0.7), tilted

    shiny = material({"color": [0.8, 0.8, 0.8], "roughness": 0.5})
    for surface in (diffuse_bsdf(look, {}), glossy_bsdf(shiny, look, {})):
        n = 400_000
        si: Any = dr.zeros(mi.SurfaceInteraction3f, n)
        si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
        si.wi = dr.normalize(mi.Vector3f(0.3, 0.2, 1.0))
        rng = np.random.default_rng(6)
        u = mi.Point2f(*rng.random((2, n)))
        ctx = mi.BSDFContext()
        _, weight = surface.sample(ctx, si, mi.Float(rng.random(n)), u)
        around = mi.warp.square_to_uniform_hemisphere(mi.Point2f(*rng.random((2, n))))
        value = surface.eval(ctx, si, around) * dr.two_pi
        by_sampling, by_chance = (float(np.array(v)[0].mean()) for v in (weight, value))
        assert by_sampling == pytest.approx(by_chance, rel=0.01)
        assert by_sampling <= 1.0


def test_a_surface_that_is_asked_for_all_at_once_shades_once(renderer: Renderer) -> None:
    del renderer
    import drjit as dr
    import mitsuba as mi

    from render.surfaces.bsdf_plugins import (
        diffuse_bsdf,
        eval_pdf_albedo,
        eval_pdf_sample_albedo,
        glossy_bsdf,
        thin_bsdf,
    )

    calls = 0

    def look(si: Any) -> tuple[Any, Any]:
        nonlocal calls
        calls += 1
        return mi.Color3f(0.1, 0.4, 0.7) * (1.0 + 0.1 * si.wi.x), mi.Normal3f(0.2, 0.0, 1.0)

    n = 1000
    rng = np.random.default_rng(11)
    si: Any = dr.zeros(mi.SurfaceInteraction3f, n)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.n = mi.Normal3f(0, 0, 1)
    si.wi = mi.warp.square_to_uniform_hemisphere(mi.Point2f(*rng.random((2, n))))
    out = mi.warp.square_to_uniform_hemisphere(mi.Point2f(*rng.random((2, n))))
    u, v, ctx = mi.Float(rng.random(n)), mi.Point2f(*rng.random((2, n))), mi.BSDFContext()
    own = (
        diffuse_bsdf(look, {}),
        thin_bsdf(look, {}, 0.3),
        glossy_bsdf(material("walnut"), look, {}),
    )
    for surface in (*own, mi.load_dict({"type": "diffuse"})):
        calls = 0
        value, pdf, albedo, _ = eval_pdf_albedo(surface, si, out)
        *_, found, weight, again, _ = eval_pdf_sample_albedo(surface, si, out, u, v)
        assert calls == (2 if surface in own else 0)
        alone = *surface.eval_pdf(ctx, si, out), surface.eval_diffuse_reflectance(si)
        assert calls == (4 if surface in own else 0)
        sample = surface.sample(ctx, si, u, v)
        pairs = zip(
            (value, pdf, albedo, again, found.wo, weight),
            (*alone, alone[2], sample[0].wo, sample[1]),
            strict=True,
        )
        for all_at_once, by_itself in pairs:
            np.testing.assert_allclose(np.array(all_at_once), np.array(by_itself), rtol=1e-6)


def test_ground_close_to_the_camera_shows_finer_detail(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    del renderer
    import mitsuba as mi

    from render.surfaces import texture_mapping
    from render.surfaces.patterns import GroundShader

    config = material({"preset": "dry soil", "steep_color": None})
    look = GroundShader(config)
    # A third of a texel apart, where the pattern itself hardly differs.
    along = config.texture_scale / 1024 / 3 * np.arange(3000)
    tones = {}
    for away in (0.4, 30.0):
        si: Any = mi.SurfaceInteraction3f()
        si.p = mi.Point3f(along, 0 * along, 0.3 * along)
        si.n = mi.Normal3f(0, 1, 0)
        si.sh_frame = mi.Frame3f(mi.Vector3f(0, 1, 0))
        si.t = mi.Float(away)
        si.wi = mi.Vector3f(0, 0, 1)
        look.values[texture_mapping.PIXEL_WIDTH] = mi.Float(1e-3)
        for strength in (texture_mapping.DETAIL, 0.0):
            monkeypatch.setattr(texture_mapping, "DETAIL", strength)
            tones[away, strength > 0.0] = np.array(look(si)[0])[0]
        monkeypatch.undo()
    rough = {key: np.abs(np.diff(tone)).mean() for key, tone in tones.items()}
    assert rough[0.4, True] > 2.0 * rough[0.4, False]
    np.testing.assert_array_equal(tones[30.0, True], tones[30.0, False])
    assert tones[0.4, True].mean() == pytest.approx(tones[0.4, False].mean(), rel=0.05)


def test_skin_has_a_soft_red_edge_of_its_shade_and_the_same_energy(renderer: Renderer) -> None:
    del renderer
    import drjit as dr
    import mitsuba as mi

    from render.surfaces.bsdf_plugins import glossy_bsdf

    def look(si: Any) -> tuple[Any, Any]:
        del si
        return mi.Color3f(0.6), mi.Normal3f(0, 0, 1)

    n = 400_000
    si: Any = dr.zeros(mi.SurfaceInteraction3f, n)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.n, si.wi = mi.Normal3f(0, 0, 1), mi.Vector3f(0, 0, 1)
    rng = np.random.default_rng(8)
    u, chosen = mi.Point2f(*rng.random((2, n))), mi.Float(rng.random(n))
    around = mi.warp.square_to_uniform_hemisphere(mi.Point2f(*rng.random((2, n))))
    grazing = np.array(around)[2] < 0.15
    ctx, found = mi.BSDFContext(), {}
    for name, share in (("plain", 0.0), ("skin", 1.0)):
        config = material(
            {"color": [0.8] * 3, "roughness": 0.9, "sheen": 0.01, "subsurface": share}
        )
        surface = glossy_bsdf(config, look, {})
        _, weight = surface.sample(ctx, si, chosen, u)
        value = np.array(surface.eval(ctx, si, around) * dr.two_pi)
        # Sampled and evaluated alike.
        np.testing.assert_allclose(np.array(weight).mean(axis=1), value.mean(axis=1), rtol=0.02)
        found[name] = value.mean(axis=1), value[:, grazing].mean(axis=1)
    np.testing.assert_allclose(found["skin"][0], found["plain"][0], rtol=0.02)
    red, green, blue = found["skin"][1] / found["plain"][1]
    assert red > 1.6 > 1.2 > green > 1.0 > blue > 0.7


def test_strands_shine_before_a_light(renderer: Renderer) -> None:
    del renderer
    import drjit as dr
    import mitsuba as mi

    from render.surfaces.bsdf_plugins import thin_bsdf

    def look(si: Any) -> tuple[Any, Any]:
        del si
        return mi.Color3f(0.1), mi.Normal3f(0, 0, 1)

    n = 200_000
    si: Any = dr.zeros(mi.SurfaceInteraction3f, n)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.n, si.wi = mi.Normal3f(0, 0, 1), dr.normalize(mi.Vector3f(1, 0, 0.4))
    rng = np.random.default_rng(9)
    u, chosen = mi.Point2f(*rng.random((2, n))), mi.Float(rng.random(n))
    around = mi.warp.square_to_uniform_sphere(mi.Point2f(*rng.random((2, n))))
    ahead = np.array(dr.dot(around, si.wi)) < -0.9
    behind = np.array(dr.dot(around, si.wi)) > 0.0
    ctx, values = mi.BSDFContext(), {}
    for sheen in (0.0, 1.0):
        surface = thin_bsdf(look, {}, 0.35, sheen)
        _, weight = surface.sample(ctx, si, chosen, u)
        values[sheen] = np.array(surface.eval(ctx, si, around))[0]
        # Sampled and evaluated alike.
        mean = 4.0 * np.pi * values[sheen].mean()
        assert np.array(weight)[0].mean() == pytest.approx(mean, rel=0.02)
    assert values[1.0][ahead].mean() > 4.0 * values[0.0][ahead].mean()
    np.testing.assert_allclose(values[1.0][behind], values[0.0][behind], rtol=1e-6)


_MEANS = """
import json, sys
sys.path[:0] = [sys.argv[1]]
import conftest, test_surfaces
from render.backend import choose
from render.renderer import Renderer
renderer = Renderer(choose(sys.argv[2]))
print(json.dumps([test_surfaces.mean_of(renderer, name) for name in sys.argv[3:]]))
"""


def test_vertex_shares_match_the_shader() -> None:
    from render.backend import choose

    choose().activate()
    from render.surfaces.mitsuba_bsdf import CREST, HOLLOW, STEEP, vertex_shares

    config = material({"preset": "dry soil", "crest_color": [1, 1, 1], "hollow_color": [0, 0, 0]})
    low, high = config.hollow_height - 1, config.crest_height + 1
    places = np.float32([[0, low, 0], [3, (low + high) / 2, 1], [7, high, 2]])
    slanted = np.float32([[0, 1, 0], [0, 1, 0], [1, 0.2, 0]])
    found = vertex_shares(config, places, slanted / np.linalg.norm(slanted, axis=1, keepdims=True))
    assert found[CREST].tolist() == [0, 0, 1]
    assert found[HOLLOW].tolist() == [1, 0, 0]
    assert found[STEEP].tolist() == [0, 0, 1]


def mean_of(renderer: Renderer, name: str) -> list[float]:
    """Return the mean light of wide, flat ground seen from above."""
    corners = np.float32([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]]) * 600
    faces = np.array([[0, 2, 1], [0, 3, 2]], np.uint32)
    mesh = Mesh("ground", corners, faces, "m", uv=corners[:, [0, 2]].copy())
    high = CameraPose((0.0, 800.0, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0))
    film = Film(size=(96, 96), samples=16, depth=2, denoise="off")
    # The scalar variant shows no clouds, which are brighter and redder than the sky.
    clear = light({"sun": {"hour": 12, "clouds": {"cumulus": 0, "cirrus": 0}}})
    light_seen = renderer.render(Shot((mesh,), {"m": material(name)}, clear, high, film)).light
    return [float(v) for v in light_seen.mean(axis=(0, 1))]


@pytest.mark.nightly
def test_the_scalar_variant_shows_ground_in_the_same_colours() -> None:
    names = ("dry soil", "sand", "snow", "grass", "tiles")
    means = []
    for backend in ("auto", "scalar"):
        folder = str(Path(__file__).parent)
        order = [sys.executable, "-c", _MEANS, folder, backend, *names]
        child = subprocess.run(order, capture_output=True, text=True, check=False)
        assert child.returncode == 0, child.stderr
        means.append(np.array(json.loads(child.stdout.splitlines()[-1])))
    np.testing.assert_allclose(means[0], means[1], rtol=0.03)


def test_walls_have_no_streaks(renderer: Renderer) -> None:
    """Laid from above, a wall would be constant along its height; it varies as much as across."""
    del renderer
    import mitsuba as mi

    from render.surfaces.patterns import GroundShader

    look = GroundShader(material({"preset": "rock", "color2": None, "bump": 0}))
    rng = np.random.default_rng(7)
    for normal in np.eye(3):
        u, v = rng.uniform(0, 50, (2, 60_000))
        axes = [axis for axis in np.eye(3) if axis @ normal == 0]
        changes = []
        for along in axes:
            colors = []
            for shift in (0.0, 0.05):
                p = np.outer(u, axes[0]) + np.outer(v, axes[1]) + shift * along
                si: Any = mi.SurfaceInteraction3f()
                si.p, si.n = mi.Point3f(*p.T), mi.Normal3f(*normal.tolist())
                si.sh_frame = mi.Frame3f(mi.Vector3f(*normal.tolist()))
                si.t, si.wi = mi.Float(0.5), mi.Vector3f(0, 0, 1)
                colors.append(np.array(look(si)[0])[0])
            changes.append(float(np.abs(colors[0] - colors[1]).mean()))
        assert changes[0] == pytest.approx(changes[1], rel=0.2)


def test_crests_and_hollows_show_their_colours(renderer: Renderer) -> None:
    if renderer.backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant shows them by attributes")
    import mitsuba as mi

    from render.surfaces.patterns import GroundShader

    green, red, blue = [0.2, 0.6, 0.2], [0.8, 0.1, 0.1], [0.1, 0.1, 0.8]
    config = material(
        {"preset": "sand", "color": green, "color2": green}
        | {"crest_color": red, "crest_height": 2.0, "hollow_color": blue, "hollow_height": -1.0}
    )
    look = GroundShader(config)
    x, z = np.random.default_rng(8).uniform(-20, 20, (2, 1000))
    strongest = []
    for y in (-3.0, 0.5, 4.0):
        si: Any = mi.SurfaceInteraction3f()
        si.p, si.n = mi.Point3f(x, y + 0 * x, z), mi.Normal3f(0, 1, 0)
        si.sh_frame, si.t = mi.Frame3f(mi.Vector3f(0, 1, 0)), mi.Float(1.0)
        si.wi = mi.Vector3f(0, 0, 1)
        strongest.append({int(i) for i in np.array(look(si)[0]).argmax(axis=0)})
    assert strongest == [{2}, {1}, {0}]


def one_print() -> FootprintRaster:
    """Return a raster with one dark square of 1 m about the origin, number 1."""
    dark = np.ones((BLOCK + 1, BLOCK + 1))
    number = np.ones(dark.shape, np.uint32)
    block = pack_texels(number, dark, np.zeros((2, *dark.shape)))
    texels = np.stack([np.zeros_like(block), block])
    return FootprintRaster((-0.5, -0.5), 1.0 / BLOCK, np.array([[1]], np.uint32), texels)


@pytest.mark.sample(1)
@pytest.mark.parametrize("still", ["", "apart", "in one scene"])
def test_a_footprint_is_visible_in_its_place_once_made(
    renderer: Renderer, make_shot: Make, monkeypatch: pytest.MonkeyPatch, still: str
) -> None:
    if still == "in one scene":
        # As on a GPU.
        monkeypatch.setattr("render.mitsuba_scene._holds_one_scene", lambda variant: True)
    if renderer.backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant shows no prints")
    shot = make_shot(camera=ABOVE, film=FILM)
    bare, thing = replace(shot.meshes[0], footprints=one_print()), shot.meshes[1]
    far = replace(thing, vertices=thing.vertices + np.float32(50.0))
    ground = replace(shot, meshes=(bare,))
    if still:
        ground = replace(shot, meshes=(far,), scenery=(bare,))

    def seen(printed: int) -> np.ndarray:
        return renderer.render(replace(ground, footprint_count=printed)).light

    before, after = seen(0), seen(1)
    assert replace(ground, footprint_count=1).digest != ground.digest
    assert replace(ground, footprint_count=1).build == ground.build
    assert seen(0).tobytes() == before.tobytes()
    changed = np.abs(after - before).max(axis=2) > 0
    row, column = np.nonzero(changed)
    # 9 m above, 35 degrees high: the picture spans 5.68 m, a pixel 8.9 cm.
    pixel = 2 * 9 * np.tan(np.radians(17.5)) / 64
    for places in (row, column):
        assert (places.min() - 32) * pixel == pytest.approx(-0.5, abs=1.5 * pixel)
        assert (places.max() + 1 - 32) * pixel == pytest.approx(0.5, abs=1.5 * pixel)
    assert after[31:33, 31:33].mean() < 0.3 * before[31:33, 31:33].mean()


@pytest.mark.nightly
def test_memory_stays_flat_over_many_scenes(renderer: Renderer, make_shot: Make) -> None:
    from render.mitsuba_scene import MitsubaScene

    def resident() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    shot = make_shot(look="walnut")
    things = [replace(mesh, rest=mesh.vertices) for mesh in shot.meshes[1:]]
    shot = replace(shot, meshes=(shot.meshes[0], *things))
    for i in range(60):
        if i == 10:
            before = resident()
        MitsubaScene(shot).trace(0, range(1), 1)
    # Building anew leaks some in Mitsuba itself; a scene that stayed alive would be far more.
    assert resident() - before < 60


@pytest.mark.nightly
def test_colours_of_needles_are_numbers(renderer: Renderer, make_shot: Make) -> None:
    if renderer.backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant shows vertex colours by a texture of Mitsuba")
    rng = np.random.default_rng(4)
    count = 20_000
    root = rng.uniform(-2.0, 2.0, (count, 3))
    tip = root + rng.normal(size=(count, 3)) * 0.3
    # So near to the edge that single precision cannot tell the corner from it.
    width = 10.0 ** rng.uniform(-5.0, -3.5, (count, 1))
    beside = root + rng.uniform(0.2, 0.8, (count, 1)) * (tip - root)
    beside += width * rng.normal(size=(count, 3))
    vertices = np.stack([root, tip, beside], axis=1).reshape(-1, 3).astype(np.float32)
    faces = np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)
    colors = np.full_like(vertices, 0.3)
    needles = Mesh("needles", vertices, faces, "leaf", colors=colors)
    shot = make_shot(camera=ABOVE, film=FILM.model_copy(update={"samples": 64}))
    materials = {**shot.materials, "leaf": Material(color=(1, 1, 1), roughness=1, translucency=0.4)}
    from render.mitsuba_scene import MitsubaScene

    scene = MitsubaScene(replace(shot, meshes=(*shot.meshes, needles), materials=materials))
    layers = scene.trace(0, range(64), 64)
    assert np.isfinite(layers.albedo).all()
    assert np.isfinite(layers.indirect_albedo).all()


@pytest.mark.parametrize(("pattern", "across"), [("slabs", 4), ("tiles", 6)])
def test_slabs_show_other_slabs_of_the_tile_and_their_own_tones(
    renderer: Renderer, pattern: str, across: int
) -> None:
    del renderer
    import mitsuba as mi

    from render.surfaces.laid_pieces import laid

    rng = np.random.default_rng(3)
    places = rng.uniform(-20.0, 20.0, (2, 4000))
    u, v = (mi.Float(p) for p in places)
    piece = laid(pattern, u, v, mi.UInt32(0), {})
    found = np.array([piece.u, piece.v])
    # The place within a course stays, so that its joints meet.
    np.testing.assert_allclose((found[1] * across) % 1.0, (places[1] * across) % 1.0, atol=2e-3)
    assert 0.02 < np.std(np.array(piece.tone)) < 0.2
    shown = np.floor(found * across)
    assert (shown >= 0).all()
    assert (shown < across).all()
    assert len({tuple(n) for n in shown.T}) == across**2
    far = laid(pattern, u, v, mi.UInt32(9), {})
    np.testing.assert_allclose(np.array(far.tone), 1.0)


@pytest.mark.parametrize(("pattern", "across"), [("slabs", 4), ("tiles", 6)])
def test_slabs_end_at_other_places_in_each_course(
    renderer: Renderer, pattern: str, across: int
) -> None:
    del renderer
    import mitsuba as mi

    from render.surfaces.laid_pieces import laid

    u = np.linspace(0.0, 24.0 / across, 4800)
    rows = (np.arange(12) + 0.5) / across
    places = np.stack(np.meshgrid(u, rows)).reshape(2, -1)
    piece = laid(pattern, *(mi.Float(p) for p in places), mi.UInt32(0), {})
    tone, along = (np.array(a).reshape(len(rows), -1) for a in (piece.tone, piece.u))
    changes = np.abs(np.diff(tone, axis=1)) > 1e-4
    ends = [u[np.flatnonzero(row)] * across for row in changes]
    lengths = np.concatenate([np.diff(row) for row in ends])
    assert lengths.min() > 0.5
    if pattern == "slabs":
        # Of mixed lengths; each begins and ends at the joints of the slab that it shows.
        assert np.ptp(lengths) > 0.6
        joint = np.abs((along * across + 0.5) % 1.0 - 0.5)
        assert joint[:, 1:][changes].max() < 0.03
    firsts = np.array([row[0] % 1.0 for row in ends])
    assert np.ptp(firsts) > 0.3


def test_boards_end_at_other_places_in_each_row(renderer: Renderer) -> None:
    del renderer
    import mitsuba as mi

    from render.surfaces.laid_pieces import laid, prepare
    from render.textures.object_patterns import BOARD_ENDS

    values: dict[str, Any] = {}
    prepare("planks", values)
    rows = (np.arange(40) + 0.5) / len(BOARD_ENDS)
    u = np.linspace(0.0, 3.0, 600)
    places = np.stack(np.meshgrid(u, rows)).reshape(2, -1)
    piece = laid("planks", *(mi.Float(p) for p in places), mi.UInt32(0), values)
    tone = np.array(piece.tone).reshape(len(rows), len(u))
    changes = np.abs(np.diff(tone, axis=1)) > 1e-4
    # Boards are as long as a tile: three metres of three tiles have three ends.
    assert set(changes.sum(axis=1)) <= {2, 3}
    ends = np.array([u[np.flatnonzero(row)[0]] for row in changes])
    assert len(np.unique(np.round(ends, 2))) > 30


@pytest.mark.nightly
def test_worn_ground_shows_soil_in_its_place(renderer: Renderer, make_shot: Make) -> None:
    if renderer.backend.variant.startswith("scalar"):
        pytest.skip("the scalar variant shows no worn ground")
    shot = make_shot(camera=ABOVE, film=FILM)
    bare = shot.meshes[0]
    texels = np.zeros((TEXELS, TEXELS), np.uint8)
    texels[TEXELS // 2 :, TEXELS // 2 :] = 255
    worn = replace(bare, wear=GroundWear((-1.0, -1.0), 2.0, texels, (0.6, 0.05, 0.05)))
    before, after = (renderer.render(replace(shot, meshes=(mesh,))).light for mesh in (bare, worn))
    assert worn.digest != bare.digest
    red = after[..., 0] / np.maximum(after.sum(axis=2), 1e-6)
    red -= before[..., 0] / np.maximum(before.sum(axis=2), 1e-6)
    rows, columns = np.nonzero(red > 0.15)
    # A pixel is 8.9 cm wide: 1 m of soil from the middle to the right and down.
    pixel = 2 * 9 * np.tan(np.radians(17.5)) / 64
    for places in (rows, columns):
        assert (places.min() - 32) * pixel == pytest.approx(0.0, abs=1.5 * pixel)
        assert (places.max() + 1 - 32) * pixel == pytest.approx(1.0, abs=1.5 * pixel)


def test_cloth_is_creased_where_its_threads_are_too_fine_to_see(renderer: Renderer) -> None:
    del renderer
    import drjit as dr
    import mitsuba as mi

    from render.surfaces.patterns import CREASE_SLOPE, BodyShader

    rng = np.random.default_rng(5)
    places = rng.uniform(0.0, 3.0, (2, 4000)).astype(np.float32)
    si = dr.zeros(mi.SurfaceInteraction3f, places.shape[1])
    si.uv = mi.Point2f(*(mi.Float(p) for p in places))
    si.p = mi.Point3f(si.uv.x, si.uv.y, 0.0)
    si.t = dr.full(mi.Float, 5.0, places.shape[1])
    si.wi = mi.Vector3f(0.0, 0.0, 1.0)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0.0, 0.0, 1.0))
    si.dp_du, si.dp_dv = mi.Vector3f(1.0, 0.0, 0.0), mi.Vector3f(0.0, 1.0, 0.0)

    def slopes(bump: float) -> np.ndarray:
        cloth = material("red cloth").model_copy(update={"bump": bump})
        _, normal = BodyShader(cloth)(si)
        return np.array(normal)[:2]

    np.testing.assert_allclose(slopes(0.2).std(axis=1), CREASE_SLOPE, rtol=0.3)
    assert np.abs(slopes(0.0)).max() == 0.0
