"""Event plots: notes, pictures and waveform at the times of score and film."""

from __future__ import annotations

import base64
import io
import wave
import xml.etree.ElementTree as ET
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from audio.config.sound import Sound
from audio.errors import SoundFileError
from audio.notes import notes_of
from audio.score import Marker, Score, ScoreEvent
from audio.wav_file import read_waveform
from pipeline.production.reports.event_plot import (
    EventPlot,
    axis_of,
    event_svg,
    plot_events,
    shown_frames,
)
from pipeline.production.reports.plot_colors import CAUSE_COLORS, cause_color
from pipeline.production.reports.plot_files import png_of
from pipeline.production.run.progress import Reporter
from pipeline.simulation.sound_detection.creature_calls import STRENGTH
from pipeline.spec.sound_thresholds import Detect

SVG = "{http://www.w3.org/2000/svg}"
RATE = Fraction(24)


def event(frame: int, cause: str = "footfall", **changes: object) -> ScoreEvent:
    """Return an event of a beetle."""
    fields = {"who": "bug", "part": f"l{frame % 3}", "material": "chitin", "distance": 4.0}
    return ScoreEvent(frame, (frame - 1) / RATE, cause, **{**fields, **changes})  # type: ignore[arg-type]


def plot_of(events: list[ScoreEvent], frames: int = 48, **fields: object) -> EventPlot:
    """Return the plot of two seconds."""
    score = Score(RATE, frames, tuple(events), Sound(), title="T & all", **fields)  # type: ignore[arg-type]
    wave_ = np.zeros((round(axis_of(score).length), 2, 2))
    return EventPlot("T & all", score, notes_of(score), (), (16, 9), wave_)


def onsets(root: ET.Element, cause: str) -> list[float]:
    """Return the left edges of shapes in a cause's color, without its legend."""
    color = cause_color(cause)
    boxes = [e for e in root.iter(f"{SVG}rect") if e.get("fill") == color and e.get("fill-opacity")]
    return sorted({round(float(e.get("x", "nan")), 3) for e in boxes})


def test_every_note_is_at_its_frame_in_the_color_of_its_cause() -> None:
    frames = {"footfall": [2, 9, 30], "collision": [9, 48], "boing": [17]}
    plot = plot_of([event(f, cause) for cause, own in frames.items() for f in own])
    axis = axis_of(plot.score)
    root = ET.fromstring(event_svg(plot))
    for cause, own in frames.items():
        expected = [axis.x + axis.length * (f - 1) / 48 for f in own]
        assert onsets(root, cause) == pytest.approx(expected, abs=1e-3)
    texts = {e.text for e in root.iter(f"{SVG}text")}
    assert {"T & all", "footfall 3", "collision 2", "boing 1", "frame 1", "1 s", "L", "R"} <= texts


def test_higher_notes_stand_higher_and_all_within_the_roll() -> None:
    plot = plot_of([event(f, size=0.02 * f) for f in range(1, 40, 3)])
    rows = {}
    for box in ET.fromstring(event_svg(plot)).iter(f"{SVG}rect"):
        if box.get("fill") == CAUSE_COLORS["footfall"] and box.get("fill-opacity"):
            rows[round(float(box.get("x", "nan")), 3)] = float(box.get("y", "nan"))
    tops = [rows[x] for x in sorted(rows)]
    pitches = [note.pitch for note in plot.notes]
    assert len(tops) == len(pitches)
    step = (max(tops) - min(tops)) / (max(pitches) - min(pitches))
    expected = [min(tops) + step * (max(pitches) - pitch) for pitch in pitches]
    assert tops == pytest.approx(expected, abs=0.01)


def test_a_lasting_note_is_a_line_that_bends_with_its_speed() -> None:
    speeds = (1.0, 2.0, 4.0, 2.0, 1.0)
    plot = plot_of([event(7, "roll", duration=1.0, speeds=speeds)])
    axis = axis_of(plot.score)
    lines = [e for e in ET.fromstring(event_svg(plot)).iter(f"{SVG}path")
             if e.get("stroke") == CAUSE_COLORS["roll"]]  # fmt: skip
    (line,) = lines
    *points, last = line.get("d", "").replace("M", " ").replace("L", " ").replace("H", " ").split()
    x, y = np.array([[float(v) for v in point.split(",")] for point in points]).T
    assert x[0] == pytest.approx(axis.at(6 / 24))
    assert float(last) == pytest.approx(axis.at(6 / 24 + 1.0))
    top = x[y.argmin()]
    assert top == pytest.approx(axis.at(6 / 24 + 0.5), abs=axis.scale / 24)
    # A quarter of the speed lies two halvings of six semitones lower.
    row = np.ptp(y) / 12
    assert y[0] - y.min() == pytest.approx(12 * row)
    assert np.all(np.diff(y[x <= top]) < 0)


def test_cuts_and_instructions_are_marked_at_their_frames() -> None:
    marks = (Marker(1, "cut", "side"), Marker(25, "script", "mare: gait trot"))
    plot = plot_of([event(3)], markers=marks)
    root = ET.fromstring(event_svg(plot))
    axis = axis_of(plot.score)
    dashed = [e for e in root.iter(f"{SVG}path") if e.get("stroke-dasharray")]
    at = [float(e.get("d", "M").lstrip("M").split(",")[0]) for e in dashed]
    assert at == pytest.approx([axis.at(0), axis.at(1)])
    assert "script: mare: gait trot" in {e.text for e in root.iter(f"{SVG}text")}


@pytest.mark.parametrize("events", [[], [event(48)], [event(1 + k % 48) for k in range(2000)]])
def test_silence_one_note_and_a_crowd_are_drawn(events: list[ScoreEvent]) -> None:
    svg = event_svg(plot_of(events))
    assert np.asarray(Image.open(io.BytesIO(png_of(svg))).convert("L"), dtype=float).std() > 5.0
    assert ("nothing is heard of 0 events" in svg) == (not events)


def test_pictures_are_at_the_times_of_their_frames() -> None:
    plot = plot_of([event(3)])
    axis = axis_of(plot.score)
    frames = shown_frames(axis, plot.shape, 48)
    assert frames[0] == 1
    assert frames == sorted(set(frames))
    assert 1 <= frames[-1] <= 48
    picture = io.BytesIO()
    Image.new("RGB", (32, 18), (200, 10, 10)).save(picture, "PNG")
    pictures = tuple((frame, picture.getvalue()) for frame in frames)
    root = ET.fromstring(event_svg(EventPlot(**{**vars_of(plot), "pictures": pictures})))
    images = list(root.iter(f"{SVG}image"))
    assert len(images) == len(frames)
    for image, frame in zip(images, frames, strict=True):
        begins = axis.at((frame - 1) / 24)
        assert -1e-3 <= float(image.get("x", "nan")) - begins < axis.scale / 24
        data = image.get("{http://www.w3.org/1999/xlink}href") or image.get("href") or ""
        assert base64.b64decode(data.split(",")[1]) == picture.getvalue()


def vars_of(plot: EventPlot) -> dict[str, object]:
    """Return the fields of a plot."""
    return {name: getattr(plot, name) for name in EventPlot.__dataclass_fields__}


def test_causes_have_distinct_and_stable_colors() -> None:
    # A call is detected in the voice of its mood.
    causes = {*Detect.model_fields, *STRENGTH}
    assert set(CAUSE_COLORS) <= causes
    assert len(set(map(cause_color, causes))) == len(causes)
    assert cause_color("meow") == cause_color("meow")


# --- waveform ------------------------------------------------------------------------------


def wav(path: Path, sound: np.ndarray, width: int = 3) -> Path:
    """Write samples (N, 2), -1 to 1, with `width` bytes each."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(width)
        file.setframerate(48_000)
        whole = np.rint(sound * (2 ** (8 * width - 1) - 1)).astype("<i4")
        file.writeframes(whole.view(np.uint8).reshape(-1, 4)[:, :width].tobytes())
    return path


@pytest.mark.parametrize("samples", [0, 7, 1000, 2_300_007])
def test_the_outline_holds_every_sample_and_no_more(tmp_path: Path, samples: int) -> None:
    rng = np.random.default_rng(samples)
    sound = rng.uniform(-1, 1, (samples, 2)) * np.array([1.0, 0.3])
    found = read_waveform(wav(tmp_path / "a.wav", sound), 50)
    assert found.shape == (50, 2, 2)
    edges = np.linspace(0, samples, 51).round().astype(int)
    for k, (a, b) in enumerate(pairwise(edges)):
        if b > a:
            assert found[k, :, 0] == pytest.approx(sound[a:b].min(axis=0), abs=1e-6)
            assert found[k, :, 1] == pytest.approx(sound[a:b].max(axis=0), abs=1e-6)
        else:
            assert not found[k].any()


def test_other_sound_files_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(SoundFileError, match=r"gone\.wav: cannot be read"):
        read_waveform(tmp_path / "gone.wav", 10)
    (tmp_path / "torn.wav").write_bytes(b"RIFF")
    with pytest.raises(SoundFileError, match=r"torn\.wav: cannot be read"):
        read_waveform(tmp_path / "torn.wav", 10)
    with pytest.raises(SoundFileError, match="no WAV file of 24 bits and two sides"):
        read_waveform(wav(tmp_path / "coarse.wav", np.zeros((9, 2)), 2), 10)


# --- the command ---------------------------------------------------------------------------


@pytest.mark.nightly
def test_event_plot_command_draws_rendered_frames_and_overwrites_none(studio, pronk) -> None:
    frames = {path.name: path.read_bytes() for path in (studio.made / "frames").iterdir()}
    code, _, message = pronk("plot", "events", "tiny", cwd=studio.folder)
    assert code == 0
    assert "0 rendered small, 7 kept" in message
    assert frames == {path.name: path.read_bytes() for path in (studio.made / "frames").iterdir()}
    svg, png = (studio.made / f"tiny_events.{end}" for end in ("svg", "png"))
    assert len(list(ET.parse(svg).getroot().iter(f"{SVG}image"))) == 7
    assert np.asarray(Image.open(png).convert("L"), dtype=float).std() > 5.0
    assert pronk("plot", "events", "tiny", "--no-pictures", "-q", cwd=studio.folder)[0] == 0
    assert not list(ET.parse(svg).getroot().iter(f"{SVG}image"))


@pytest.mark.nightly
def test_missing_frames_are_rendered_small_and_not_stored(unmade, tmp_path) -> None:
    studio = unmade.copied(tmp_path / "studio")
    svg, _ = plot_events(studio.order(), Reporter())
    assert len(list(ET.parse(svg).getroot().iter(f"{SVG}image"))) > 1
    assert not list(studio.made.rglob("frames/*"))


@pytest.mark.slow
def test_event_plot_command_refuses_with_one_message(studio, pronk) -> None:
    code, _, message = pronk("plot", "events", "tiny_", cwd=studio.folder)
    assert code == 2
    assert "did you mean" in message
    assert "Traceback" not in message
