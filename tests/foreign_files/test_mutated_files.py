"""Mutated files: whatever is in a foreign file, it is read or refused with one message."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from audio.config.sound import Sound
from audio.errors import SoundFontError
from audio.score import Score, ScoreEvent
from audio.soundfont import play_soundfont, soundfont_fault
from pipeline.errors import SceneError
from pipeline.foreign_files.reader_process import shared_process
from pipeline.simulation.bodies.body_model import build_body
from pipeline.simulation.terrain.height_files import mesh, read_gray
from pipeline.spec.body import MeshBody
from pipeline.spec.terrain.kinds import MeshTerrain
from render.errors import ShotError
from render.panorama_file import panorama_fault, read_panorama
from tests.foreign_files.mutation import formats, mutated

RIGHT = "right"


def use_soundfont(path: Path) -> str:
    """Check and play a SoundFont; return what is wrong with it."""
    fault = soundfont_fault(path)
    try:
        sound = play_soundfont(SCORE, path, 4800)
    except SoundFontError as error:
        return f"check: {fault}; play: {error}"
    assert sound.shape == (4800, 2)
    assert np.isfinite(sound).all()
    return fault or RIGHT


def use_mesh(path: Path) -> str:
    """Use a mesh as terrain and as a body; return what is wrong with it."""
    faults = []
    try:
        field = mesh(MeshTerrain(file=str(path)), np.random.default_rng(1))
        assert np.isfinite(field.heights).all()
    except SceneError as error:
        faults.append(str(error))
    try:
        assert build_body(MeshBody(shape="mesh", file=str(path)), "body").mass.mass > 0.0
    except SceneError as error:
        faults.append(str(error))
    # A cube is a right body and no terrain.
    return "; ".join(faults) if len(faults) == 2 else RIGHT


def use_panorama(path: Path) -> str:
    """Check a panorama and read it as light; return what is wrong with it."""
    fault = panorama_fault(path)
    try:
        image = read_panorama(path)
    except ShotError as error:
        assert fault is not None
        return f"check: {fault}; render: {error}"
    assert np.isfinite(image).all()
    assert image.shape[1] == 2 * image.shape[0]
    return fault or RIGHT


def use_height_map(path: Path) -> str:
    """Read a height map; return what is wrong with it."""
    try:
        values = read_gray(str(path))
    except SceneError as error:
        return str(error)
    assert ((values >= 0.0) & (values <= 1.0)).all()
    return RIGHT


USES: dict[str, Callable[[Path], str]] = {
    ".sf2": use_soundfont,
    ".ply": use_mesh,
    ".obj": use_mesh,
    ".hdr": use_panorama,
    ".exr": use_panorama,
    ".png": use_height_map,
}
SCORE = Score(
    Fraction(24),
    2,
    tuple(
        ScoreEvent(frame=1, time=Fraction(0), cause="footfall", who=who, strength=1.0)
        for who in ("ant", "bug")
    ),
    Sound(),
)


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Keep verdicts on mutated files out of the user's cache, and read all in one child."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with shared_process():
        yield


def outcomes(folder: Path, suffix: str, count: int) -> Counter[str]:
    """Use mutated files of a format and count how it went: right, refused, crashed, late."""
    corpus = formats(folder)[suffix]
    found = Counter[str]()
    for seed in range(count):
        path = folder / f"mutated{suffix}"
        path.write_bytes(mutated(corpus, seed))
        fault = USES[suffix](path)
        kind = "right" if fault == RIGHT else "refused"
        kind = "crashed its reader" if "crashes" in fault else kind
        found["took too long" if "takes longer than" in fault else kind] += 1
    assert found.total() == count
    # Otherwise the mutations would test nothing, or break everything at once.
    assert found["right"]
    assert found["refused"]
    return found


@pytest.mark.parametrize("suffix", USES)
def test_every_unmutated_file_is_right(tmp_path: Path, suffix: str) -> None:
    for number, content in enumerate(formats(tmp_path)[suffix]):
        path = tmp_path / f"right{number}{suffix}"
        path.write_bytes(content)
        assert USES[suffix](path) == RIGHT


@pytest.mark.parametrize("suffix", USES)
def test_some_mutated_files_are_read_or_refused(tmp_path: Path, suffix: str) -> None:
    outcomes(tmp_path, suffix, 60)


@pytest.mark.nightly
@pytest.mark.parametrize("suffix", USES)
def test_two_thousand_mutated_files_are_read_or_refused(
    tmp_path: Path, suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found = outcomes(tmp_path, suffix, 2000)
    with capsys.disabled():
        print(f"\n{suffix}: {dict(found)}")  # noqa: T201 - the law asks for the counts
