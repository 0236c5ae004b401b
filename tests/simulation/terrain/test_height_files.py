"""Terrains from files: their heights are those of the file, and invalid files are refused."""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from pipeline.errors import SceneError
from pipeline.simulation.mesh_file import MeshError, obj_vertices, ply_vertices
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.height_files import grid_of
from pipeline.spec import load_scene, simulation_key

SCENE = "pronk: 1\nduration: 1\nterrain: {config}\ncast: [{{prop: {{shape: ball}}}}]\n"
COLUMN = len("terrain: {kind: image, file: ") + 1


def build_ground_of(folder: Path, config: str) -> Ground:
    path = folder / "scene.yaml"
    path.write_text(SCENE.format(config=config), encoding="utf-8")
    return Simulation(load_scene(path)).world.ground


def refusal_message(folder: Path, config: str) -> str:
    with pytest.raises(SceneError) as caught:
        build_ground_of(folder, config)
    (problem,) = caught.value.problems
    assert problem.path == "terrain.file"
    assert (problem.file, problem.line) == (str(folder / "scene.yaml"), 3)
    assert problem.column == len("terrain: " + config.partition("file: ")[0] + "file: ") + 1
    return problem.message


def smooth_heights(rows: int, columns: int) -> Array:
    x, z = np.meshgrid(np.linspace(0, 2, columns), np.linspace(0, 3, rows))
    return 0.5 + 0.4 * np.sin(x) * np.cos(z)


@pytest.mark.parametrize(("bits", "most"), [(8, 255), (16, 65535)])
def test_heights_of_an_image_are_its_pixels(tmp_path: Path, bits: int, most: int) -> None:
    pixels = np.rint(smooth_heights(31, 41) * most).astype(np.uint8 if bits == 8 else np.uint16)
    Image.fromarray(pixels).save(tmp_path / "land.png")
    field = build_ground_of(
        tmp_path, "{kind: image, file: land.png, size: [20, 15], low: -1, high: 1.5}"
    ).field
    assert field.cells == (40, 30)
    assert field.heights == pytest.approx(-1 + 2.5 * pixels / most, abs=1e-12)
    # Seen from above the image is upright: its first row is at the lowest z.
    corner = field.height(np.array(-10.0), np.array(-7.5))
    assert float(corner) == pytest.approx(-1 + 2.5 * pixels[0, 0] / most)


def test_an_image_may_be_sampled_on_another_grid(tmp_path: Path) -> None:
    pixels = np.tile(np.arange(0, 250, 10, dtype=np.uint8), (9, 1))
    Image.fromarray(pixels).save(tmp_path / "slope.png")
    config = "{kind: image, file: slope.png, size: [24, 8], cells: [7, 5], low: 0, high: 2.55}"
    field = build_ground_of(tmp_path, config).field
    x = np.linspace(0, 24, 8)
    assert field.heights == pytest.approx(np.tile(0.1 * x, (6, 1)))


def test_files_are_relative_to_the_scene_also_in_sums(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "maps").mkdir()
    Image.fromarray(np.full((4, 4), 51, np.uint8)).save(tmp_path / "maps/land.png")
    monkeypatch.chdir("/")
    config = "{kind: sum, cells: [8, 6], of: [flat, {kind: image, file: maps/land.png, high: 1}]}"
    assert build_ground_of(tmp_path, config).field.heights == pytest.approx(np.full((7, 9), 0.2))


def test_the_simulation_key_depends_on_the_content_of_the_file(tmp_path: Path) -> None:
    def key(value: int, name: str = "land.png", more: str = "") -> str:
        Image.fromarray(np.full((4, 4), value, np.uint8)).save(tmp_path / name)
        path = tmp_path / "scene.yaml"
        path.write_text(SCENE.format(config=f"{{kind: image, file: {name}{more}}}"), "utf-8")
        return simulation_key(load_scene(path))

    assert key(1) == key(1) == key(1, "other.png")
    assert key(1) != key(2)
    assert key(1) == key(1, more=", show_forbidden: true")


def png(kind: str, size: tuple[int, int] = (5, 5)) -> bytes:
    stream = io.BytesIO()
    Image.new(kind, size).save(stream, "PNG")
    return stream.getvalue()


def with_size(width: int, height: int) -> bytes:
    """Return a PNG whose header has another size than its data."""
    whole = png("L")
    header = struct.pack(">II", width, height) + whole[24:29]
    return whole[:16] + header + struct.pack(">I", zlib.crc32(b"IHDR" + header)) + whole[33:]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"no picture at all", "'a.png' is no PNG picture"),
        (b"", "'a.png' is no PNG picture"),
        (png("L", (50, 50))[:60], "'a.png' cannot be read: "),
        (png("RGB"), "'a.png' is a picture of kind RGB; should be grayscale of 8 or 16 bits"),
        (png("P"), "'a.png' is a picture of kind P; should be grayscale of 8 or 16 bits"),
        (png("L", (2, 9)), "'a.png' has 2 x 9 pixels, fewer than 3 x 3"),
        (with_size(4001, 3), "'a.png' has 4001 x 3 pixels, more than 4000 x 4000; make it smaller"),
        (with_size(12_000, 12_000), "'a.png' has 12000 x 12000 pixels, more than 4000 x 4000"),
        (with_size(90_000, 90_000), "'a.png' is larger than 4000 x 4000 pixels"),
    ],
    ids=range(9),
)
def test_unusable_images_are_refused(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "a.png").write_bytes(content)
    assert refusal_message(tmp_path, "{kind: image, file: a.png}").startswith(message)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    message = refusal_message(tmp_path, "{kind: image, file: b.png}")
    assert message == f"'b.png' is no file in {tmp_path}"
    assert refusal_message(tmp_path, "{kind: mesh, file: .}").endswith("is a folder, not a file")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
@pytest.mark.parametrize("kind", ["image", "mesh"])
def test_links_to_devices_and_named_pipes_are_refused_at_once(tmp_path: Path, kind: str) -> None:
    (tmp_path / "a.ply").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "b.ply")
    config = f"{{kind: {kind}, file: a.ply}}"
    assert refusal_message(tmp_path, config) == "'a.ply' is a device, not a file"
    config = f"{{kind: {kind}, file: b.ply}}"
    assert refusal_message(tmp_path, config) == "'b.ply' is a named pipe, not a file"


GRID = smooth_heights(5, 7)


def grid_mesh(heights: Array = GRID, origin: tuple[float, float] = (-2, 1)) -> trimesh.Trimesh:
    rows, columns = heights.shape
    x, z = np.meshgrid(origin[0] + 0.4 * np.arange(columns), origin[1] + 0.5 * np.arange(rows))
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([a, a + columns, a + 1], 1),
            np.stack([a + 1, a + columns, a + columns + 1], 1),
        ]
    )
    vertices = np.stack([x, heights, z], axis=-1).reshape(-1, 3)
    return trimesh.Trimesh(vertices, faces, process=False)


def shuffled(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    order = np.random.default_rng(1).permutation(len(mesh.vertices))
    return trimesh.Trimesh(mesh.vertices[order], np.argsort(order)[mesh.faces], process=False)


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.obj", lambda mesh: mesh.export(file_type="obj").encode()),
        ("a.ply", lambda mesh: mesh.export(file_type="ply", encoding="ascii")),
        ("a.PLY", lambda mesh: mesh.export(file_type="ply", encoding="binary")),
    ],
)
def test_a_grid_mesh_keeps_its_coordinates(
    tmp_path: Path, name: str, write: Callable[[trimesh.Trimesh], bytes]
) -> None:
    mesh = shuffled(grid_mesh())
    (tmp_path / name).write_bytes(write(mesh))
    field = build_ground_of(tmp_path, f"{{kind: mesh, file: {name}, at: [10, 20]}}").field
    assert field.cells == (6, 4)
    assert field.size == pytest.approx((2.4, 2.0), abs=1e-6)
    x, y, z = mesh.vertices.T
    assert field.height(x + 10, z + 20) == pytest.approx(y, abs=1e-6)


def test_a_mesh_may_have_z_up_a_scale_and_a_heading(tmp_path: Path) -> None:
    mesh = grid_mesh()
    x, y, z = mesh.vertices.T
    raised = trimesh.Trimesh(np.stack([x, -z, y], 1) * 100, mesh.faces, process=False)
    (tmp_path / "a.obj").write_text(raised.export(file_type="obj"))
    config = "{kind: mesh, file: a.obj, up: z, scale: 0.01, heading_deg: 90}"
    field = build_ground_of(tmp_path, config).field
    # A quarter turn about +Y takes x to -z and z to x.
    assert field.height(z, -x) == pytest.approx(y, abs=1e-6)


def bent(change: Callable[[Array], None]) -> bytes:
    vertices = np.array(grid_mesh().vertices)
    change(vertices)
    return "".join(f"v {x} {y} {z}\n" for x, y, z in vertices).encode()


def uneven(vertices: Array) -> None:
    vertices[:, 0] = np.where(vertices[:, 0] > 0.1, vertices[:, 0] + 0.1, vertices[:, 0])


def off_its_line(vertices: Array) -> None:
    vertices[8, 0] += 0.1


def above_another(vertices: Array) -> None:
    vertices[8, [0, 2]] = vertices[9, [0, 2]]


NO_GRID = "'a.obj' is no regular grid in x and z: "


NO_COUNT = "'a.ply' cannot be read: its header says no number of vertices with x, y and z"

TOO_MANY = "'a.ply' has more than 16008001 vertices; make it simpler"


def ply_head(count: str) -> bytes:
    """Return the header of a PLY file that claims a number of vertices and holds none."""
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    return f"ply\nformat ascii 1.0\nelement vertex {count}\n{axes}end_header\n".encode()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.obj", bent(uneven), NO_GRID + "its values of x are not evenly spaced"),
        ("a.obj", bent(off_its_line), NO_GRID + "its values of x are not evenly spaced"),
        ("a.obj", bent(above_another), NO_GRID + "two of its vertices lie above one another"),
        (
            "a.obj",
            bent(lambda v: None) + b"v 0 0 1\n",
            NO_GRID + "it has 36 vertices, and 7 x 5 places for them",
        ),
        (
            "a.obj",
            bent(lambda v: v.__setitem__((slice(None), 2), 0.0)),
            NO_GRID + "1 different values of z, where 3 to 4001 are needed",
        ),
        (
            "a.obj",
            bent(lambda v: v.__imul__(1e5)),
            "'a.obj' reaches farther than 10000 m; is its scale right?",
        ),
        ("a.obj", b"v 1 2 3\n", "'a.obj' has 1 vertices, fewer than 9"),
        ("a.obj", b"v 1 2\nv 1 2 3\n", "'a.obj' cannot be read: a vertex is not three numbers"),
        (
            "a.obj",
            b"\x00\xff nothing",
            "'a.obj' cannot be read: it has no vertices (lines that begin with v)",
        ),
        ("a.obj", b"v nan 0 0\n" * 9, "'a.obj' has a vertex that is not finite"),
        ("a.stl", b"solid", "'a.stl' should end in .obj or .ply"),
        (
            "a.ply",
            b"plx\n",
            "'a.ply' cannot be read: it does not begin with the header of a PLY file",
        ),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement face 3\nelement vertex 9\nend_header\n",
            "'a.ply' cannot be read: its first element is 'face'; should be 'vertex'",
        ),
        (
            "a.ply",
            grid_mesh().export(file_type="ply", encoding="binary")[:400],
            "'a.ply' cannot be read: it ends before its last vertex",
        ),
        ("a.ply", ply_head("²"), NO_COUNT),
        ("a.ply", ply_head("9" * 5000), NO_COUNT),
        ("a.ply", ply_head("-1"), NO_COUNT),
        (
            "a.ply",
            ply_head("99999999999"),
            "'a.ply' has more than 16008001 vertices; make it simpler",
        ),
        ("a.ply", ply_head("0"), "'a.ply' has 0 vertices, fewer than 9"),
        (
            "a.ply",
            ply_head("1").replace(b" y", b" x"),
            "'a.ply' cannot be read: its vertices have two properties 'x'",
        ),
        (
            "a.obj",
            b"v 1e308 0 1e308\n" * 9,
            "'a.obj' reaches farther than 10000 m; is its scale right?",
        ),
    ],
    ids=range(21),
)
def test_meshes_that_are_no_grid_are_refused_with_the_reason(
    tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(content)
    assert refusal_message(tmp_path, f"{{kind: mesh, file: {name}}}") == message


@given(
    st.binary(max_size=300)
    | st.text("ply\nformat ascii 1.0elemntvrxpyz end_hadif ").map(str.encode)
)
def test_any_bytes_are_read_or_refused(content: bytes) -> None:
    for read in (obj_vertices, ply_vertices):
        for start in (
            b"",
            b"v 1 2 3\n",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1\n",
        ):
            try:
                vertices = read(start + content, 1000)
            except MeshError:
                continue
            assert vertices.shape[1:] == (3,)
            if np.isfinite(vertices).all() and len(vertices):
                try:
                    grid_of(vertices)
                except MeshError:
                    continue
