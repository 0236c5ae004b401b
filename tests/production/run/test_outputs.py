"""Outputs: films of exactly the requested frames, and notes on the frames."""

from __future__ import annotations

import json
import wave
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest
import symusic

from pipeline.atomic_file import make_folder
from pipeline.errors import StoreError
from pipeline.production.run import outputs as output_files
from pipeline.production.run.production import score_only
from pipeline.production.run.progress import Reporter
from render.development import developed
from render.image_files import read_development, read_exr, read_png

if TYPE_CHECKING:
    from tests.production.conftest import Studio

Pronk = Callable[..., tuple[int, str, str]]


def shown(film: Path) -> list[np.ndarray]:
    with av.open(str(film)) as container:
        return [f.to_ndarray(format="rgb24") for f in container.decode(container.streams.video[0])]


def sounds(film: Path) -> list[str]:
    with av.open(str(film)) as container:
        return [stream.type for stream in container.streams]


@pytest.mark.parametrize(
    ("frames", "name", "count", "streams"),
    [
        ("1-3", "tiny_1-3.mp4", 3, ["video", "audio"]),
        ("7,5,6", "tiny_5-7.mp4", 3, ["video", "audio"]),
        ("1-8x3", "tiny_1-7x3.mp4", 3, ["video"]),
        ("1-2,8", "tiny_1-2_8.mp4", 3, ["video"]),
    ],
)
def test_a_part_of_the_film_has_the_requested_frames(
    studio: Studio, frames: str, name: str, count: int, streams: list[str]
) -> None:
    before = studio.state()
    studio.render(frames=frames)
    assert studio.changes(before) == {name, "manifest.json"}
    assert len(shown(studio.made / name)) == count
    assert sounds(studio.made / name) == streams


def test_a_films_pictures_are_its_frames_in_order(film: Studio) -> None:
    pictures = shown(film.made / "tiny.mp4")
    assert len(pictures) == 8
    frames = [read_png(film.frame(f)).astype(float) for f in range(1, 9)]
    for i, picture in enumerate(pictures):
        away = [float(np.abs(picture - frame).mean()) for frame in frames]
        assert int(np.argmin(away)) == i
        # The more contrast, the more the codec loses.
        assert away[i] < 10


def _onsets(path: Path) -> list[Fraction]:
    """Return the times of all note-ons, from the file alone, exactly."""
    score = symusic.Score(str(path), ttype="tick")
    (tempo,) = score.tempos
    tick = Fraction(round(tempo.mspq), 1_000_000 * score.tpq)
    return sorted(note.time * tick for track in score.tracks for note in track.notes)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "fps", ["30000/1001", *(pytest.param(f, marks=pytest.mark.slow) for f in ("24", "25", "60"))]
)
def test_every_note_is_on_the_frame_of_its_event(studio: Studio, fps: str) -> None:
    # A pitch for each foot keeps the notes of one frame apart.
    order = studio.order(f"fps={fps}", "frames=40", "sound.voices=[{pitch: by foot}]")
    outputs = score_only(order, Reporter())
    lines = outputs.events.read_text(encoding="utf-8").splitlines()
    frames = sorted(json.loads(line)["frame"] for line in lines)
    rate = order.scene.rate
    assert len(frames) >= 6
    assert _onsets(outputs.midi) == [(frame - 1) / rate for frame in frames]


def test_scoring_renders_nothing(unmade: Studio, tmp_path: Path, pronk: Pronk) -> None:
    studio = unmade.copied(tmp_path / "studio")
    code, out, _ = pronk("midi", "tiny", cwd=studio.folder)
    assert (code, out) == (0, "out/tiny/tiny.mid\n")
    assert not (studio.made / "frames").exists()
    assert not list(studio.made.glob("*.mp4"))
    with wave.open(str(studio.made / "tiny.wav")) as sound:
        assert Fraction(sound.getnframes(), sound.getframerate()) == Fraction(8, 24)


def heard(path: Path) -> tuple[np.ndarray, int]:
    """Return the louder of both sides, and the sample rate."""
    with av.open(str(path)) as container:
        stream = container.streams.audio[0]
        blocks = [frame.to_ndarray() for frame in container.decode(stream)]
        return np.abs(np.concatenate(blocks, axis=1)).max(axis=0), stream.rate


def test_sound_starts_on_its_frame(film: Studio) -> None:
    """The first steps of all stand alone; before them there is silence."""
    lines = (film.made / "events.jsonl").read_text(encoding="utf-8").splitlines()
    first = min(json.loads(line)["frame"] for line in lines)
    signal, rate = heard(film.made / "tiny.mp4")
    # AAC spreads less than a twentieth of the peak ahead of an onset.
    onset = int(np.argmax(signal > 0.05 * signal.max())) / rate
    assert first > 2
    assert onset == pytest.approx((first - 1) / 24, abs=0.001)


def test_sound_of_a_part_equals_that_of_the_film(studio: Studio) -> None:
    """The first steps are heard 4 frames after the start, or 2 after that of frames 3-8."""
    studio.render(frames="3-8")
    onsets = []
    for name in ("tiny.mp4", "tiny_3-8.mp4"):
        signal, rate = heard(studio.made / name)
        onsets.append(float(np.argmax(signal > 0.05 * signal.max())) / rate)
    assert onsets[0] - onsets[1] == pytest.approx(2 / 24, abs=0.001)


@pytest.mark.nightly
def test_a_film_without_sound_has_no_sound_track(unmade: Studio, tmp_path: Path) -> None:
    studio = unmade.copied(tmp_path / "studio")
    studio.render(sound=False, frames="1-2")
    assert not list(studio.made.glob("*.mid"))
    assert not list(studio.made.glob("*.wav"))
    assert sounds(studio.made / "tiny_1-2.mp4") == ["video"]


@pytest.mark.slow
def test_frames_in_exr_make_the_same_film_as_their_pictures(studio: Studio) -> None:
    studio.render("film.format=png", frames="1-2")
    before_film = np.array(shown(studio.made / "tiny_1-2.mp4"), int)
    before = studio.state()
    studio.render("film.format=exr", frames="1-2")
    made = {"frames/0001.exr", "frames/0002.exr", "manifest.json", "tiny_1-2.mp4"}
    assert studio.changes(before) == made
    for frame in (1, 2):
        file = studio.made / "frames" / f"000{frame}.exr"
        off = developed(read_exr(file), read_development(file)).astype(int) - read_png(
            studio.frame(frame)
        ).astype(int)
        # Light kept in half precision is off by a grey value here and there.
        assert np.abs(off).max() <= 1
    off = np.array(shown(studio.made / "tiny_1-2.mp4"), int) - before_film
    assert np.abs(off).mean() < 4.0
    before = studio.state()
    studio.render("film.format=exr", frames="1-2")
    assert studio.changes(before) == set()


@pytest.mark.nightly
def test_a_master_has_ten_bits_and_uncompressed_sound(studio: Studio) -> None:
    sets = ("film.preset=master", "film.size=[64,36]", "film.samples=1", "film.denoise=off")
    studio.render(*sets)
    film = studio.made / "tiny.mov"
    with av.open(str(film)) as container:
        (video,) = container.streams.video
        assert (video.codec_context.name, video.pix_fmt) == ("prores", "yuv422p10le")
        pictures = list(container.decode(video=0))
    times = [Fraction(frame.pts) * frame.time_base for frame in pictures]
    assert times == [Fraction(k, 24) for k in range(8)]
    # Ten bits have levels between those of eight.
    levels = np.unique(pictures[3].to_ndarray(format="gray16le") >> 6)
    assert np.count_nonzero(levels % 4) > np.count_nonzero(levels % 4 == 0)
    with av.open(str(film)) as container:
        heard = np.concatenate([b.to_ndarray() for b in container.decode(audio=0)], axis=1)
    with av.open(str(studio.made / "tiny.wav")) as container:
        sound = np.concatenate([b.to_ndarray() for b in container.decode(audio=0)], axis=1)
    np.testing.assert_array_equal(heard, sound)
    assert "tiny.mov" in (studio.made / "tiny.edl").read_text()
    assert (studio.made / "frames" / "0008.exr").exists()


@pytest.mark.slow
def test_another_codec_encodes_the_film_again_and_nothing_else(
    film: Studio, tmp_path: Path
) -> None:
    studio = film.copied(tmp_path / "studio")
    first = (studio.made / "tiny.mp4").read_bytes()
    before = studio.state()
    studio.render("film.codec=vp9")
    assert studio.changes(before) == {"tiny.mp4", "manifest.json"}
    with av.open(str(studio.made / "tiny.mp4")) as container:
        assert [s.codec_context.name for s in container.streams] == ["vp9", "opus"]
    assert len(shown(studio.made / "tiny.mp4")) == 8
    before = studio.state()
    studio.render("film.codec=vp9")
    assert studio.changes(before) == set()
    studio.render("film.codec=av1", "film.container=webm")
    assert studio.changes(before) == {"tiny.webm", "tiny.edl", "manifest.json"}
    before = studio.state()
    studio.render("film.codec=av1", "film.container=webm")
    assert studio.changes(before) == set()
    studio.render()
    assert (studio.made / "tiny.mp4").read_bytes() == first


def test_a_missing_encoder_is_told_with_its_line_before_anything_is_made(
    studio: Studio, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = av.Codec

    def lacking(name: str, mode: str) -> av.Codec:
        return real("no such encoder" if name == "libsvtav1" else name, mode)

    monkeypatch.setattr(av, "Codec", lacking)
    lines = [line for line in studio.scene.read_text().splitlines() if "film" not in line]
    scene = studio.folder / "other.yaml"
    scene.write_text("\n".join([*lines, "film:", "  codec: av1", ""]))
    wanted = (
        f"error: other.yaml:{len(lines) + 2}:10: film.codec: the installed PyAV {av.__version__} "
        "cannot encode av1: it lacks libsvtav1; write h264 or prores or vp9\n"
    )
    for command in ("check", "render"):
        code, out, err = pronk(command, "other.yaml", cwd=studio.folder)
        assert (code, out) == (3, "")
        assert err.startswith(wanted)
    assert not (studio.folder / "out" / "other").exists()


def test_a_single_frame_equals_that_of_the_film(film: Studio, tmp_path: Path, pronk: Pronk) -> None:
    studio = film.copied(tmp_path / "studio")
    before = studio.state()
    assert pronk("frame", "tiny", "3", cwd=studio.folder)[1] == "out/tiny/frames/0003.png\n"
    assert studio.changes(before) == set()
    studio.frame(3).unlink()
    assert pronk("frame", "tiny", "3", cwd=studio.folder)[0] == 0
    assert studio.changes(before) == {"frames/0003.png", "manifest.json"}
    assert studio.contents() == film.contents()


def test_a_sheet_shows_frames_of_the_film(studio: Studio, pronk: Pronk) -> None:
    before = studio.state()
    arguments = ("sheet", "tiny", "--count", "4", "--columns", "2")
    assert pronk(*arguments, cwd=studio.folder)[1] == "out/tiny/tiny_sheet.png\n"
    assert studio.changes(before) == {"tiny_sheet.png", "manifest.json"}
    sheet = read_png(studio.made / "tiny_sheet.png")
    assert sheet.shape == (2 * 36 + 3 * 6, 2 * 64 + 3 * 6, 3)
    np.testing.assert_array_equal(sheet[6:42, 6:70], read_png(studio.frame(1)))
    np.testing.assert_array_equal(sheet[48:84, 76:140], read_png(studio.frame(8)))


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["虫の歩み", "Käfer läuft", "a.b", "it's 100% [new]"])
def test_any_name_in_any_folder_makes_a_film(
    unmade: Studio, tmp_path: Path, pronk: Pronk, name: str
) -> None:
    folder = tmp_path / "ein Ordner ß"
    folder.mkdir()
    text = unmade.scene.read_text(encoding="utf-8").replace("title: Tiny", f'title: "{name}"')
    (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    arguments = ("--out", "the films", "--frames", "1-2")
    code, out, _ = pronk("render", f"ein Ordner ß/{name}", *arguments, cwd=tmp_path)
    assert (code, out) == (0, f"the films/{name}\n")
    made = tmp_path / "the films" / name
    assert len(shown(made / f"{name}_1-2.mp4")) == 2
    assert json.loads((made / "manifest.json").read_text(encoding="utf-8"))["title"] == name
    # Cues name the sounds; an independent reader finds the notes.
    assert len(_onsets(made / f"{name}.mid")) == 6


def test_json_lines_are_valid(studio: Studio, pronk: Pronk) -> None:
    studio.frame(4).unlink()
    code, out, err = pronk("render", "tiny", "--json", cwd=studio.folder)
    events = [json.loads(line) for line in out.splitlines()]
    assert (code, err) == (0, "")
    stages = [one["stage"] for one in events if one["event"] == "begin"]
    assert stages == ["simulate", "score", "render", "film"]
    assert [one["stage"] for one in events if one["event"] == "end"] == stages
    done = [
        one["done"] for one in events if one["event"] == "progress" and one["stage"] == "render"
    ]
    assert done == [7, 8]
    assert events[-1] == {"event": "result", "text": "out/tiny"}


def test_a_folder_whose_name_is_too_long_is_told(tmp_path: Path) -> None:
    place = output_files.Outputs(tmp_path / ("x" * 300) / "tiny", "tiny")
    with (
        pytest.raises(StoreError, match=r"cannot be written to \(File name too long\)"),
        output_files.opened(place),
    ):
        pass


def test_quiet_runs_print_nothing(studio: Studio, pronk: Pronk) -> None:
    studio.frame(4).unlink()
    assert pronk("render", "tiny", "-q", cwd=studio.folder) == (0, "", "")
    assert studio.frame(4).is_file()


def test_log_output_lists_the_stages(studio: Studio, pronk: Pronk) -> None:
    studio.frame(4).unlink()
    code, out, err = pronk("render", "tiny", cwd=studio.folder)
    assert (code, out) == (0, "out/tiny\n")
    assert "simulate: take is up to date (" in err
    assert "render: 1 frame, " in err
    assert ", 7 kept (" in err
    assert "film: tiny.mp4 is up to date (" in err


def test_the_frames_folder_is_there_though_a_run_that_ended_removed_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outputs = output_files.Outputs(tmp_path / "scene", "scene")
    made: list[Path] = []

    def removed_by_another_run(folder: Path) -> None:
        make_folder(folder)
        if not made:
            folder.rmdir()
        made.append(folder)

    monkeypatch.setattr(output_files, "make_folder", removed_by_another_run)
    with output_files.opened(outputs):
        assert outputs.frames.is_dir()
