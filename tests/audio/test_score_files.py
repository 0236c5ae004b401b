"""The score for other programs: stems, performers, Reaper projects and MusicXML."""

from __future__ import annotations

import io
import re
import struct
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mido
import numpy as np
import pytest

from audio.errors import NotationError, ScoreError
from audio.midi_file import midi_bytes
from audio.names import file_stems
from audio.notation import musicxml
from audio.performer_files import write_performers
from audio.reaper_project import reaper_project
from audio.score import DanceBeat, Marker, Score
from audio.stems import write_stems
from audio.time_grid import sample_of_frame
from audio.wav_file import read_samples, write_wav


@pytest.fixture
def band(step: Any, score_of: Any) -> Score:
    """Return a score of two performers who dance from 1 s on."""
    played = [
        *(step(25 + 14 * k, who="ida", material="wood") for k in range(5)),
        *(step(25 + 28 * k, who="tom", material="steel", cause="collision") for k in range(3)),
        step(30, who="tom", material="steel", cause="scuff"),
    ]
    score: Score = score_of(
        played,
        120,
        sound={"tempo_bpm": 103, "scale": "D dorian", "room": "hall"},
        title='The "band"',
        markers=(Marker(49, "cut", "side of ida"),),
    )
    return replace(score, dance=DanceBeat(Fraction(103), Fraction(1)))


def read_float_wav(path: Path) -> Any:
    data = path.read_bytes()
    assert (data[:4], data[8:16]) == (b"RIFF", b"WAVEfmt ")
    size, form, sides, rate = struct.unpack("<IHHI", data[16:28])
    assert (form, sides, rate) == (3, 2, 48_000)
    at = 20 + size
    while data[at : at + 4] != b"data":
        at += 8 + struct.unpack("<I", data[at + 4 : at + 8])[0]
    assert len(data) == at + 8 + struct.unpack("<I", data[at + 4 : at + 8])[0]
    return np.frombuffer(data[at + 8 :], "<f4").reshape(-1, 2)


def test_stems_add_up_to_the_track(band: Score, tmp_path: Path) -> None:
    report = write_wav(band, tmp_path / "track.wav")
    stems = list(write_stems(band, tmp_path, report.gain))
    assert [stem.path.name for stem in stems] == [
        "ida_footfall.wav", "tom_collision.wav", "tom_scuff.wav",
    ]  # fmt: skip
    samples = sample_of_frame(band.frames + 1, band.rate)
    track = read_samples(report.path, 0, samples)
    total = sum(read_float_wav(stem.path).astype(float) for stem in stems)
    assert total.shape == (samples, 2)
    # Within -80 dB of the peak.
    assert np.abs(total - track).max() < 1e-4 * np.abs(track).max()
    assert report.curve is not None
    assert not any(stem.changed for stem in write_stems(band, tmp_path, report.gain))


def test_a_soundfont_has_no_stems(band: Score, tmp_path: Path) -> None:
    sound = band.sound.model_copy(update={"soundfont": "my.sf2"})
    with pytest.raises(ScoreError, match="soundfont"):
        list(write_stems(replace(band, sound=sound), tmp_path, 0.0))


def test_each_performer_has_a_file_with_its_notes_at_the_same_ticks(
    band: Score, tmp_path: Path, read_smf: Any, check_laws: Any
) -> None:
    files = list(write_performers(band, tmp_path))
    assert [(file.performer, file.path.name) for file in files] == [
        ("ida", "ida.mid"), ("tom", "tom.mid"),
    ]  # fmt: skip
    whole = read_smf(midi_bytes(band))
    parts = [read_smf(file.path.read_bytes()) for file in files]
    for part in parts:
        check_laws(part, band.frames, band.rate)
        assert (part.division, part.tempos, part.meters) == (
            whole.division, whole.tempos, whole.meters,
        )  # fmt: skip
    together = sorted((tick, pitch) for part in parts for tick, _, pitch, _ in part.onsets())
    assert together == sorted((tick, pitch) for tick, _, pitch, _ in whole.onsets())


def test_files_are_named_after_performers_and_each_once() -> None:
    names = file_stems(["a/b", "a:b", "A_B", "..", "Käfer 甲", "x" * 300])
    assert list(names.values()) == ["a_b", "a_b_2", "A_B_3", "unnamed", "Käfer_甲", "x" * 40]


def test_a_reaper_project_has_tempo_markers_stems_and_scores(band: Score, tmp_path: Path) -> None:
    (tmp_path / "stems").mkdir()
    (tmp_path / "performers").mkdir()
    stems = list(write_stems(band, tmp_path / "stems", 0.0))
    performers = list(write_performers(band, tmp_path / "performers"))
    text = reaper_project(band, stems, performers, tmp_path).decode()
    # Every block is closed.
    depth = 0
    for line in text.splitlines():
        depth += line.lstrip().startswith("<") - (line.strip() == ">")
        assert depth >= 0
    assert depth == 0
    named = re.findall(r'FILE "(.+?)"', text)
    assert set(named) == {
        "stems/ida_footfall.wav", "stems/tom_collision.wav", "stems/tom_scuff.wav",
        "performers/ida.mid", "performers/tom.mid",
    }  # fmt: skip
    assert all((tmp_path / name).is_file() for name in named)
    points = [line.split() for line in text.splitlines() if line.startswith("    PT")]
    assert [float(point[1]) for point in points] == pytest.approx([0, 1], abs=0.02)
    assert float(points[1][2]) == pytest.approx(103)
    assert int(points[1][4]) == 4 + 4 * 65536
    assert 'MARKER 1 2.000000000000 "cut: side of ida" 0' in text
    # Folders of tracks are closed too.
    assert sum(int(bus.split()[1]) for bus in re.findall(r"ISBUS (.+)", text)) == 0


def test_sheet_music_has_the_bars_of_the_score(band: Score) -> None:
    music21 = pytest.importorskip("music21")
    data = musicxml(band)
    assert data == musicxml(band)
    sheet = music21.converter.parseData(data.decode(), format="musicxml")
    assert [part.partName for part in sheet.parts] == ["ida", "tom"] or len(sheet.parts) >= 2
    ida = next(part for part in sheet.parts if part.partName == "ida")
    meters = [each.ratioString for each in ida.recurse().getElementsByClass("TimeSignature")]
    assert meters == ["7/16", "4/4"]
    first, second = list(ida.getElementsByClass("Measure"))[:2]
    assert not list(first.notes)
    # The dance begins on the second bar line; its steps are quarter notes.
    notes = list(ida.recurse().notes)
    start = second.offset
    assert [n.getOffsetInHierarchy(ida) - start for n in notes] == [0, 1, 2, 3, 4]
    (key,) = ida.recurse().getElementsByClass("KeySignature")
    assert key.sharps == 0
    marks = [mark.number for mark in sheet.recurse().getElementsByClass("MetronomeMark")]
    assert 103 in marks


def test_another_reader_finds_the_notes_of_the_midi_file(band: Score) -> None:
    music21 = pytest.importorskip("music21")
    data = midi_bytes(band)
    file = mido.MidiFile(file=io.BytesIO(data), charset="utf-8")
    read = music21.midi.MidiFile()
    read.readstr(data)
    assert read.ticksPerQuarterNote == file.ticks_per_beat
    onsets = []
    for track in read.tracks:
        now = 0
        for event in track.events:
            if event.isDeltaTime():
                now += event.time
            elif event.isNoteOn():
                onsets.append((now, event.pitch))
    expected = []
    for track in file.tracks:
        now = 0
        for message in track:
            now += message.time
            if message.type == "note_on" and message.velocity:
                expected.append((now, message.note))
    assert sorted(onsets) == sorted(expected)


def test_sheet_music_without_its_library_is_an_error(
    band: Score, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "music21", None)
    with pytest.raises(NotationError, match="pip install music21"):
        musicxml(band)
