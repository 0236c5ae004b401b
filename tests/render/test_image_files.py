"""PNG and EXR files with keys."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from render.errors import FrameFileError
from render.image_files import (
    has_digest,
    read_exr,
    read_key,
    read_png,
    write_exr,
    write_png,
)

RNG = np.random.default_rng(1)


@pytest.mark.parametrize("size", [(16, 16), (1, 5), (37, 19)])
def test_png_keeps_pixels_and_key(tmp_path: Path, size: tuple[int, int]) -> None:
    pixels = RNG.integers(0, 256, (*size, 3), dtype=np.uint8)
    write_png(tmp_path / "a.png", pixels, "abc|1")
    np.testing.assert_array_equal(read_png(tmp_path / "a.png"), pixels)
    assert read_key(tmp_path / "a.png") == "abc|1"


@pytest.mark.parametrize("suffix", ["png", "exr"])
def test_a_truncated_file_has_no_key(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    if suffix == "png":
        write_png(path, RNG.integers(0, 256, (8, 8, 3), dtype=np.uint8), "key")
    else:
        write_exr(path, RNG.random((8, 8, 3), dtype=np.float32), "key")
    whole = path.read_bytes()
    assert read_key(path) == "key"
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert read_key(path) is None, length


@pytest.mark.parametrize("suffix", ["png", "exr"])
def test_a_file_that_was_changed_has_no_key_and_is_not_read(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    if suffix == "png":
        write_png(path, RNG.integers(0, 256, (8, 8, 3), dtype=np.uint8), "key")
    else:
        write_exr(path, RNG.random((8, 8, 3), dtype=np.float32), "key")
    whole = path.read_bytes()
    # Most of the pixels, before the end of a PNG file.
    for at in range(len(whole) - 190, len(whole) - 20):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x41]) + whole[at + 1 :])
        assert read_key(path) is None, at
    with pytest.raises(FrameFileError, match="render it again"):
        (read_png if suffix == "png" else read_exr)(path)


def test_another_picture_beside_the_texts_of_the_first_has_no_key(tmp_path: Path) -> None:
    path, texts = tmp_path / "a.png", PngImagePlugin.PngInfo()
    write_png(path, np.zeros((4, 4, 3), np.uint8), "key")
    with Image.open(path) as image:
        for name, text in image.text.items():
            texts.add_text(name, text)
    Image.new("RGB", (4, 4), "white").save(path, pnginfo=texts)
    assert has_digest(path)
    assert read_key(path) is None
    with pytest.raises(FrameFileError, match="is not as it was written"):
        read_png(path)
    # A picture of another program, which knows nothing of digests, can be read and has no key.
    Image.new("RGB", (4, 4), "white").save(path)
    assert not has_digest(path)
    assert read_png(path).min() == 255
    assert read_key(path) is None


def test_foreign_and_missing_files_have_no_key(tmp_path: Path) -> None:
    (tmp_path / "x.png").write_bytes(b"GIF89a" + bytes(100))
    assert read_key(tmp_path / "x.png") is None
    assert read_key(tmp_path / "none.png") is None
    with pytest.raises(FrameFileError, match="render it again"):
        read_png(tmp_path / "x.png")


def test_writing_leaves_no_temporary_files(tmp_path: Path) -> None:
    write_png(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), "1")
    write_png(tmp_path / "a.png", np.zeros((4, 4, 3), np.uint8), "2")
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]
    assert read_key(tmp_path / "a.png") == "2"


def test_an_error_of_a_file_passes_between_processes(tmp_path: Path) -> None:
    with pytest.raises(FrameFileError) as caught:
        read_png(tmp_path / "none.png")
    passed = pickle.loads(pickle.dumps(caught.value))
    assert (str(passed), passed.path) == (str(caught.value), tmp_path / "none.png")


def test_an_unwritable_path_is_reported(tmp_path: Path) -> None:
    with pytest.raises(FrameFileError, match="could not be written"):
        write_png(tmp_path / "none" / "a.png", np.zeros((4, 4, 3), np.uint8), "1")


@pytest.mark.usefixtures("renderer")
def test_another_reader_reads_the_exr(tmp_path: Path) -> None:
    import mitsuba as mi

    light = RNG.random((9, 14, 3), dtype=np.float32) * 100
    light[2] = 0
    write_exr(tmp_path / "a.exr", light, "key")
    read = np.array(mi.Bitmap(str(tmp_path / "a.exr"))).astype(np.float32)
    np.testing.assert_array_equal(read, light.astype(np.float16).astype(np.float32))
