"""Renderer: exact updates, energy, exposure and repeatability."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from render.backend import Backend
from render.config import Film, material
from render.errors import ShotError
from render.frame import Image, LightLayers
from render.lights.sun_position import sun_direction
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Shot

Make = Callable[..., Shot]


@pytest.mark.slow
def test_a_mesh_moved_in_place_equals_a_fresh_build(
    renderer: Renderer, backend: Backend, make_shot: Make
) -> None:
    renderer.render(make_shot(x=-0.7))
    build_time = renderer.timings.build
    moved = renderer.render(make_shot(x=0.4)).light
    assert renderer.timings.build == build_time
    fresh = Renderer(backend).render(make_shot(x=0.4)).light
    np.testing.assert_array_equal(moved, fresh)
    assert not np.array_equal(moved, renderer.render(make_shot(x=-0.7)).light)


def test_camera_and_field_of_view_move_without_a_build(
    renderer: Renderer, backend: Backend, make_shot: Make
) -> None:
    renderer.render(make_shot())
    build_time = renderer.timings.build
    pose = CameraPose((-2.0, 3.0, 2.0), (0.0, 0.2, 0.0), fov_deg=60.0)
    moved = renderer.render(make_shot(camera=pose)).light
    assert renderer.timings.build == build_time
    np.testing.assert_array_equal(moved, Renderer(backend).render(make_shot(camera=pose)).light)


@pytest.mark.parametrize(("samples", "expected"), [(2, True), (48, False)])
def test_shadows_of_the_sun_are_denoised_where_samples_are_few(
    renderer: Renderer,
    make_shot: Make,
    monkeypatch: pytest.MonkeyPatch,
    samples: int,
    expected: bool,
) -> None:
    seen = []

    def clean(layers: LightLayers, mode: str, *, has_soft_lights: bool) -> Image:
        del mode
        seen.append(has_soft_lights)
        return layers.light

    monkeypatch.setattr(renderer._denoiser, "clean", clean)
    film = Film(size=(32, 32), samples=samples, depth=2, denoise="fast")
    renderer.render(make_shot(film=film))
    assert seen == [expected]


@pytest.mark.nightly
def test_denoised_frames_repeat(renderer: Renderer, backend: Backend, make_shot: Make) -> None:
    film = Film(size=(64, 48), samples=2, depth=3, denoise="fast")
    first = renderer.render(make_shot(film=film)).light
    np.testing.assert_array_equal(first, Renderer(backend).render(make_shot(film=film)).light)


def test_a_convex_body_in_a_furnace_shows_its_albedo(renderer: Renderer) -> None:
    """A convex body in a sky of radiance 1 shows its albedo, whatever its shape."""
    import mitsuba as mi

    from render.meshes import build_mesh, group_meshes

    n, m = 24, 48
    theta, phi = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, m, False))
    ball = np.stack(
        [np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1
    ).reshape(-1, 3)
    i = np.arange(n * m).reshape(m, n)
    j = np.roll(i, -1, axis=0)
    quads = [q.ravel() for q in (i[:, :-1], j[:, :-1], j[:, 1:], i[:, 1:])]
    faces = np.concatenate(
        [np.stack([quads[0], quads[1], quads[2]], 1), np.stack([quads[0], quads[2], quads[3]], 1)]
    )
    mesh = Mesh("ball", ball.astype(np.float32), faces.astype(np.uint32), "m")
    config = material({"color": [0.5, 0.5, 0.5], "roughness": 1.0})
    (group,) = group_meshes([mesh], {"m": config})
    scene = mi.load_dict(
        {
            "type": "scene",
            "ball": build_mesh(group, [mesh], config),
            "sky": {"type": "constant"},
            "camera": {
                "type": "perspective",
                "fov": 10,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
            },
        }
    )
    seen = np.array(mi.load_dict({"type": "path", "max_depth": 2}).render(scene, spp=256))[..., 0]
    # sRGB 0.5 is an albedo of 0.214; a coat of dielectric adds a few hundredths.
    assert 0.2 < seen.mean() < 0.27


def test_a_grey_card_is_middle_grey_by_day(renderer: Renderer) -> None:
    """The exposure is designed: a card of 18% half turned to the sun has radiance near 0.2."""
    from render.config import light

    lit = light("day")
    assert lit.sun is not None
    n = np.add(sun_direction(lit.sun), (0.0, 1.0, 0.0))
    n /= np.linalg.norm(n)
    u = np.cross(n, [1.0, 0, 0])
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    corners = np.array([-u - v, u - v, u + v, -u + v], np.float32) * 5
    card = Mesh("card", corners, np.array([[0, 2, 1], [0, 3, 2]], np.uint32), "card", smooth=False)
    config = material({"color": [0.4613561] * 3, "roughness": 1.0})
    film = Film(size=(16, 16), samples=256, depth=2, denoise="off")
    pose = CameraPose(tuple((4 * n).tolist()), (0.0, 0.0, 0.0), up=tuple(u.tolist()), fov_deg=10)
    seen = renderer.render(Shot((card,), {"card": config}, lit, pose, film)).light
    expected = 0.18 * 1.25
    luma = float((seen @ np.array([0.2126, 0.7152, 0.0722])).mean())
    assert luma == pytest.approx(expected, rel=0.15)


def test_normals_of_a_sphere_point_outward() -> None:
    from render.vertex_normals import vertex_normals

    corners = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    normals = vertex_normals(corners.astype(np.float32), np.array(faces, np.uint32))
    np.testing.assert_allclose(normals, corners, atol=1e-6)


def test_collapsed_triangles_stay_finite(renderer: Renderer, make_shot: Make) -> None:
    shot = make_shot()
    gone = replace(shot.meshes[1], vertices=np.zeros((4, 3), np.float32), smooth=True)
    hidden = replace(shot, meshes=(shot.meshes[0], gone, shot.meshes[2]))
    assert np.isfinite(renderer.render(hidden).light).all()


@pytest.mark.nightly
def test_only_warned_faces_are_red(
    renderer: Renderer, make_shot: Make, make_ground: Callable[..., Mesh]
) -> None:
    from_above = CameraPose((0.0, 9.0, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0))
    film = Film(size=(64, 64), samples=16, depth=2, denoise="off")
    shot = make_shot(camera=from_above, film=film)
    ground = make_ground(cells=200)
    upper = ground.vertices[ground.faces].mean(axis=1)[:, 2] < 0

    def seen(tinted: np.ndarray | None) -> np.ndarray:
        return renderer.render(replace(shot, meshes=(replace(ground, warned=tinted),))).light

    plain, none, one, both = (seen(t) for t in (None, ~upper & upper, upper, upper | ~upper))

    def red(light: np.ndarray) -> np.ndarray:
        return light[..., 0] / light.sum(axis=-1)

    np.testing.assert_allclose(none.mean(axis=(0, 1)), plain.mean(axis=(0, 1)), rtol=0.01)
    # A cell is 2.3 pixels, and the border is as soft as that.
    halves = [float(np.mean(red(one)[half] > 0.58)) for half in (slice(29), slice(35, 64))]
    assert halves == pytest.approx([1.0, 0.0], abs=0.02)
    assert red(both).min() > red(plain).max()


@pytest.mark.sample(2)
@pytest.mark.parametrize("lit", ["day", "noon", "golden hour", "overcast", "studio", "dawn"])
def test_every_light_is_finite_and_well_exposed(
    renderer: Renderer, make_shot: Make, lit: str
) -> None:
    frame = renderer.render(make_shot(lit=lit))
    assert np.isfinite(frame.light).all()
    assert frame.light.min() >= 0
    assert 50 < frame.srgb8.mean() < 190


def test_invalid_shots_are_reported(renderer: Renderer, make_shot: Make) -> None:
    shot = make_shot()
    with pytest.raises(ShotError, match="names material 'dry soil'"):
        renderer.render(replace(shot, materials={"bone": material("bone")}))
    here = CameraPose((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    with pytest.raises(ShotError, match="cannot look at"):
        renderer.render(replace(shot, camera=here))
    short = replace(shot.meshes[1], warned=np.zeros(3, bool))
    with pytest.raises(ShotError, match="3 values for 4 faces"):
        renderer.render(replace(shot, meshes=(shot.meshes[0], short, shot.meshes[2])))
    torn = replace(shot.meshes[1], vertices=np.full((4, 3), np.nan, np.float32))
    with pytest.raises(ShotError, match="not finite"):
        renderer.render(replace(shot, meshes=(shot.meshes[0], torn, shot.meshes[2])))
    # The renderer renders the next valid shot.
    assert np.isfinite(renderer.render(shot).light).all()


def test_a_camera_may_look_straight_down(renderer: Renderer, make_shot: Make) -> None:
    frame = renderer.render(make_shot(camera=CameraPose((0.0, 6.0, 0.0), (0.0, 0.0, 0.0))))
    assert np.isfinite(frame.light).all()
    assert frame.light.mean() > 0.01


_ALONE = """
import sys, hashlib
sys.path[:0] = [sys.argv[1]]
import conftest
from render.backend import choose
from render.renderer import Renderer
from render.shot import CameraPose, Shot
from render.config import Film, light, material
renderer = Renderer(choose(), threads=int(sys.argv[2]))
film = Film(size=(96, 64), samples=4, depth=4, denoise="fast")
materials = {"dry soil": material("dry soil"), "bone": material("green chitin")}
for x in (0.0, 0.3):
    meshes = (conftest.plane(cells=20), conftest.tetrahedron((x, 0.5, 0.0)))
    pose = CameraPose((3.0, 2.0, 4.0), (0.0, 0.3, 0.0))
    frame = renderer.render(Shot(meshes, materials, light("day"), pose, film))
    print(hashlib.sha256(frame.light.tobytes() + frame.srgb8.tobytes()).hexdigest())
"""


def _alone(threads: int, home: Path | None = None) -> str:
    environment = dict(os.environ)
    if home is not None:  # Dr.Jit keeps its compiled kernels under the home directory
        environment |= {"HOME": str(home), "XDG_CACHE_HOME": str(home)}
    folder = str(Path(__file__).parent)
    child = subprocess.run(
        [sys.executable, "-c", _ALONE, folder, str(threads)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert child.returncode == 0, child.stderr
    return child.stdout


@pytest.mark.nightly
def test_pixels_repeat_in_other_processes_threads_and_caches(tmp_path: Path) -> None:
    first = _alone(2)
    assert len(first.split()) == 2
    assert _alone(2) == first
    assert _alone(1) == first
    assert _alone(2, home=tmp_path) == first


@pytest.mark.nightly
def test_memory_stays_flat_over_many_frames(renderer: Renderer, make_shot: Make) -> None:
    def resident() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    shots = [make_shot(x=0.01 * i) for i in range(60)]
    for shot in shots[:20]:
        renderer.render(shot)
    before = resident()
    for shot in shots[20:]:
        renderer.render(shot)
    assert resident() - before < 8


@pytest.mark.nightly
def test_the_scalar_variant_renders() -> None:
    code = _ALONE.replace("choose()", "choose('scalar')")
    child = subprocess.run(
        [sys.executable, "-c", code, str(Path(__file__).parent), "2"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert child.returncode == 0, child.stderr
    assert len(child.stdout.split()) == 2
