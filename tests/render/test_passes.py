"""Passes: Cryptomatte by its specification, depth, normals, motion and coverage by closed forms."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from render.config import Film, light, material
from render.image_files import read_exr, read_key, read_passes, write_exr
from render.passes.cryptomatte import cryptomatte, object_hash
from render.passes.pass_images import SKY_DEPTH, PassPart
from render.renderer import Renderer
from render.shot import CameraPose, Mesh, Moment, Shot

SIZE = (64, 32)
FOV = 40.0
SCALE = SIZE[1] / 2 / math.tan(math.radians(FOV) / 2)
"""Pixels of a metre at a distance of a metre."""


def test_hashes_are_those_of_the_specification() -> None:
    # From the sample files of the specification, and the bits that must not become infinite.
    assert object_hash("hello") == 0x248BFA47
    for k in range(3000):
        assert (object_hash(f"name{k}") >> 23) & 255 not in (0, 255)


def test_a_pixel_holds_what_covers_it_from_the_largest_share() -> None:
    ids = np.array([1, 2, 2, 0, 3, 2, 1, 1], np.uint32)[:, None, None]
    ids = np.concatenate([ids, np.full_like(ids, 3)], axis=2)
    matte = cryptomatte("CryptoObject", ["", "a", "b", "a"], ids)
    first = matte.layers[0]
    a, b = (np.array([object_hash(name)], np.uint32).view(np.float32)[0] for name in "ab")
    # Numbers 1 and 3 are one object.
    np.testing.assert_array_equal(first[0, 0], [a, 0.5, b, 0.375])
    np.testing.assert_array_equal(first[0, 1], [a, 1.0, 0.0, 0.0])
    assert not np.any(matte.layers[1:])
    texts = {name.split("/")[2]: text for name, text in matte.attributes.items()}
    assert json.loads(texts["manifest"]) == {
        "a": f"{object_hash('a'):08x}",
        "b": matte.manifest["b"],
    }


def plate(name: str, z: float, shift: float = 0.0) -> Mesh:
    """Return an upright square of 0.5 m that faces the camera."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.25 + [shift, 0, z]
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    return Mesh(name, corners.astype(np.float32), faces, "white", smooth=False, owner=name[:4])


def test_passes_have_their_closed_forms(renderer: Renderer, tmp_path: Path) -> None:
    film = Film(
        size=SIZE,
        samples=4,
        depth=1,
        denoise="off",
        format="exr",
        passes=("depth", "normal", "motion", "id", "alpha"),
    )
    camera = CameraPose((0, 0, 2), (0, 0, 0), fov_deg=FOV)
    meshes = plate("near.left", 0.5, -0.4), plate("near.right", 0.0, 0.4)
    moved = Moment((plate("near.left", 0.5, -0.3), meshes[1]), camera)
    shot = Shot(
        meshes,
        {"white": material({"color": [1, 1, 1], "roughness": 1.0})},
        light("day"),
        camera,
        film,
        after=moved,
        scenery=(plate("far", -2.0),),
    )
    frame = renderer.render(shot)
    path = tmp_path / "a.exr"
    write_exr(path, frame.light, "key", passes=frame.passes.parts())
    np.testing.assert_allclose(read_exr(path), frame.light, rtol=1e-3, atol=1e-4)
    parts = {part.name: part for part in read_passes(path)}
    z = parts["depth"].channels["Z"]
    row = SIZE[1] // 2

    def column(x: float, depth: float) -> int:
        return int(SIZE[0] / 2 + SCALE * x / depth)

    left, right, far = column(-0.4, 1.5), column(0.4, 2.0), column(0.0, 4.0)
    np.testing.assert_allclose(z[row, [left, right, far]], [1.5, 2.0, 4.0], rtol=1e-5)
    assert z[0, 0] == np.float32(SKY_DEPTH)
    normal = [parts["normal"].channels[f"N.{axis}"][row, left] for axis in "XYZ"]
    np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-6)
    u, v = (parts["motion"].channels[f"forward.{axis}"] for axis in "uv")
    np.testing.assert_allclose(u[row, [left, right, far]], [SCALE * 0.1 / 1.5, 0, 0], atol=1e-4)
    assert abs(v).max() < 1e-4
    alpha = parts["alpha"].channels["A"]
    # Squares of (0.5 / depth)^2, clear of one another.
    area = SCALE**2 * 0.25 * (1.5**-2 + 2.0**-2 + 4.0**-2)
    assert alpha.sum() == pytest.approx(area, rel=0.01)
    objects = parts["CryptoAsset"]
    text = next(x for name, x in objects.attributes.items() if name.endswith("manifest"))
    assert json.loads(text).keys() == {"near", "far"}
    near = np.array([object_hash("near")], np.uint32).view(np.float32)[0]
    shares = sum(
        np.where(objects.channels[f"CryptoAsset{k:02d}.{a}"] == near, x, 0)
        for k in range(3)
        for a, x in (
            ("R", objects.channels[f"CryptoAsset{k:02d}.G"]),
            ("B", objects.channels[f"CryptoAsset{k:02d}.A"]),
        )
    )
    assert shares.sum() == pytest.approx(SCALE**2 * 0.25 * (1.5**-2 + 2.0**-2), rel=0.01)


def test_a_camera_that_turns_moves_the_sky(renderer: Renderer) -> None:
    film = Film(size=SIZE, samples=4, depth=1, denoise="off", format="exr", passes=("motion",))
    camera = CameraPose((0, 0, 2), (0, 0, 0), fov_deg=FOV)
    turned = CameraPose((0, 0, 2), (0.02, 0, 0), fov_deg=FOV)
    mesh = plate("ball", 0.0)
    shot = Shot((mesh,), {"white": material("bone")}, light("day"), camera, film)
    shot = replace(shot, after=Moment((mesh,), turned))
    motion = renderer.render(shot).passes.motion
    assert motion is not None
    # The middle of the picture, on the plate, and the sky beside it go to the left alike.
    middle = motion[SIZE[1] // 2, [SIZE[0] // 2, SIZE[0] // 2 + 20]]
    np.testing.assert_allclose(middle[0], [-SCALE * 0.01, 0], atol=2e-3)
    assert middle[1, 0] < -SCALE * 0.01


def test_a_changed_pass_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    values = np.random.default_rng(1).random((8, 8)).astype(np.float32)
    # Columns in memory one after another, as the denoiser leaves a frame.
    frame = np.moveaxis(np.random.default_rng(2).random((3, 8, 8)).astype(np.float32), 0, -1)
    for passes in ([PassPart("depth", {"Z": values})], [PassPart("depth", {"Z": values + 1})]):
        write_exr(path, frame, "key", passes=passes)
        assert read_key(path) == "key"
        np.testing.assert_allclose(read_exr(path), frame, atol=1e-3)
    whole = path.read_bytes()
    path.write_bytes(whole[:-40] + bytes([whole[-40] ^ 0x41]) + whole[-39:])
    assert read_key(path) is None


def test_passes_need_exr_frames() -> None:
    with pytest.raises(ValueError, match="write format: exr"):
        Film.model_validate({"passes": ["depth"]})
    assert Film.model_validate({"preset": "master", "passes": ["depth"]}).resolved().passes
    with pytest.raises(ValueError, match="twice"):
        Film.model_validate({"format": "exr", "passes": ["id", "id"]})
