"""Damaged outputs: a file that is not what was written is made again, and nothing else is."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from render.image_files import read_key, read_png, write_png

if TYPE_CHECKING:
    from tests.production.conftest import Studio

Pronk = Callable[..., tuple[int, str, str]]

NIGHTLY = pytest.mark.nightly


def flip(path: Path, count: int = 50) -> None:
    """Flip bytes in the second half of a file."""
    data = bytearray(path.read_bytes())
    for k in range(count):
        data[len(data) // 2 + k] ^= 0xFF
    path.write_bytes(data)


def zero_the_end(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: -len(data) // 4] + bytes(len(data) - len(data[: -len(data) // 4])))


def in_secret(harm: Callable[[Path], None], path: Path) -> None:
    """Do harm that neither size nor time of the file tells."""
    before = path.stat()
    harm(path)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert path.stat().st_size == before.st_size


@pytest.mark.parametrize("harm", [flip, pytest.param(zero_the_end, marks=NIGHTLY)])
def test_a_damaged_film_is_encoded_again(
    studio: Studio, film: Studio, harm: Callable[[Path], None]
) -> None:
    before = studio.state()
    harm(studio.made / "tiny.mp4")
    studio.render()
    assert studio.changes(before) == {"tiny.mp4", "manifest.json"}
    assert studio.contents() == film.contents()


def brightened(path: Path) -> np.ndarray:
    return np.minimum(read_png(path).astype(int) + 40, 255).astype(np.uint8)


def rewrite_with_key(path: Path) -> None:
    """Change the picture as another program that keeps its key, and keep the file sound."""
    write_png(path, brightened(path), read_key(path) or "")


def edit(path: Path) -> None:
    """Change the picture and keep all its texts."""
    pixels, texts = brightened(path), PngImagePlugin.PngInfo()
    with Image.open(path) as image:
        for name, text in image.text.items():
            texts.add_text(name, text)
    Image.fromarray(pixels).save(path, pnginfo=texts)


@pytest.mark.parametrize("harm", [rewrite_with_key, pytest.param(edit, marks=NIGHTLY)])
def test_a_frame_that_another_program_changed_is_rendered_again(
    studio: Studio, film: Studio, harm: Callable[[Path], None]
) -> None:
    before = studio.state()
    harm(studio.frame(4))
    studio.render()
    assert studio.changes(before) == {"frames/0004.png", "manifest.json"}
    assert studio.contents() == film.contents()


@NIGHTLY
def test_frames_of_a_run_that_was_stopped_count_only_as_they_were_written(
    studio: Studio, film: Studio
) -> None:
    before = studio.state()
    (studio.made / "manifest.json").unlink()
    edit(studio.frame(4))
    studio.render()
    assert studio.changes(before) == {"frames/0004.png", "tiny.mp4", "manifest.json"}
    assert studio.contents() == film.contents()


@NIGHTLY
def test_a_copied_file_is_read_once_and_kept(studio: Studio) -> None:
    os.utime(studio.frame(4))
    os.utime(studio.made / "tiny.mp4")
    before = studio.state()
    studio.render()
    assert studio.changes(before) == {"manifest.json"}
    before = studio.state()
    studio.render()
    assert studio.changes(before) == set()


@pytest.mark.nightly
def test_a_frame_that_turns_out_damaged_ends_one_run_at_most(
    studio: Studio, film: Studio, pronk: Pronk
) -> None:
    in_secret(lambda path: flip(path, 5), studio.frame(4))
    (studio.made / "tiny.mp4").unlink()
    code, _, err = pronk("render", "tiny", cwd=studio.folder)
    assert code == 4
    assert "out/tiny/frames/0004.png is no" in err
    assert "Traceback" not in err
    studio.render()
    assert studio.contents() == film.contents()


@NIGHTLY
def test_what_a_failed_run_has_made_is_recorded(studio: Studio, pronk: Pronk) -> None:
    studio.frame(4).unlink()
    # The film cannot replace a folder.
    (studio.made / "tiny.mp4").unlink()
    (studio.made / "tiny.mp4" / "in the way").mkdir(parents=True)
    assert pronk("render", "tiny", cwd=studio.folder)[0] == 4
    manifest = json.loads((studio.made / "manifest.json").read_text())
    recorded = manifest["files"]["frames/0004.png"]
    assert recorded["mtime_ns"] == studio.frame(4).stat().st_mtime_ns


@NIGHTLY
def test_a_take_that_is_damaged_where_nobody_reads_is_made_again(
    studio: Studio, film: Studio, pronk: Pronk
) -> None:
    metadata = json.loads((studio.made / "take.zarr/zarr.json").read_text(encoding="utf-8"))
    metadata["attributes"]["columns"]["nodes"] = ["none"]
    (studio.made / "take.zarr/zarr.json").write_text(json.dumps(metadata), encoding="utf-8")
    code, _, err = pronk("simulate", "tiny", cwd=studio.folder)
    assert code == 0
    assert "the take is damaged: it is not as it was written; it is made again" in err
    assert studio.contents() == film.contents()


@NIGHTLY
@pytest.mark.parametrize("entry", [None, 3, [], "x", {"digest": 3}, {"digest": "x", "size": "1"}])
def test_odd_records_in_a_manifest_count_for_nothing(
    studio: Studio, film: Studio, entry: object
) -> None:
    place = studio.made / "manifest.json"
    manifest = json.loads(place.read_text(encoding="utf-8"))
    for odd in (entry, {name: entry for name in manifest["files"]}):
        place.write_text(json.dumps({**manifest, "files": odd, "films": odd}), encoding="utf-8")
        studio.render()
        assert studio.contents() == film.contents()
