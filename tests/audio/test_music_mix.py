"""Music in the track: onsets, level beside the events, ducking, stems and channels."""

from __future__ import annotations

import wave
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from audio.buses import yielding
from audio.config.sound import Mix
from audio.layouts import STEREO
from audio.loudness_meter import integrated_loudness
from audio.midi_file import write_midi
from audio.music_mix import mix_music
from audio.notes import notes_of
from audio.performer_files import write_performers
from audio.stems import write_stems
from audio.surround_file import write_surround
from audio.time_grid import SAMPLE_RATE
from audio.wav_file import mix_score, write_wav

KIT = {
    "parts": {"kit": {"reverb": 0}},
    "sections": {"a": {"play": {"kit": {"drums": {"claves": "x...x..."}}}}},
}
DUO = {
    "parts": {
        "bass": {"instrument": "fingered bass", "octave": -2, "pan": -0.5},
        "pad": {"instrument": "string ensemble 1", "pan": 0.5},
    },
    "sections": {
        "a": {"chords": "Am | F", "play": {"bass": {"tones": "0 2"}, "pad": {"rhythm": "x"}}}
    },
}


def sound_with(music: dict[str, Any], **sound: Any) -> dict[str, Any]:
    """Return the configuration of music at 103 beats a minute."""
    return {"tempo_bpm": 103, "music": music, **sound}


def read_stem(path: Path) -> Any:
    """Return the samples of a file of floats: (N, 2)."""
    data = path.read_bytes()
    return np.frombuffer(data[data.index(b"data") + 8 :], "<f4").reshape(-1, 2).astype(float)


def test_onsets_of_music_are_on_its_beats_within_a_millisecond(score_of: Any) -> None:
    score = score_of(sound=sound_with(KIT, room="dry", master="off"), frames=240)
    mix, _ = mix_score(score, notes_of(score), 10 * SAMPLE_RATE)
    loud = np.abs(mix).max(axis=1)
    beats = np.arange(0, 10, 2 * 60 / 103)
    for beat in beats:
        first = round(beat * SAMPLE_RATE)
        # Silent before it, and loud within a millisecond.
        assert loud[max(first - 480, 0) : first].max(initial=0) < 0.02 * loud.max()
        assert loud[first : first + 48].max() > 0.1 * loud.max()


@pytest.mark.parametrize("level_db", [-6, 0, 9])
def test_music_is_as_much_louder_than_the_events_as_is_written(
    level_db: float, step: Any, score_of: Any
) -> None:
    events = [step(frame) for frame in range(1, 120, 6)]
    score = score_of(events, frames=120, sound=sound_with({**DUO, "level_db": level_db}))
    notes = notes_of(score)
    mix, gain = mix_score(score, notes, 5 * SAMPLE_RATE)
    alone = [note for note in notes if not note.is_music]
    events_alone, _ = mix_score(score, alone, 5 * SAMPLE_RATE)
    music = mix - events_alone
    assert gain != 1
    difference = integrated_loudness(music) - integrated_loudness(events_alone)
    assert difference == pytest.approx(level_db, abs=0.1)


def test_music_alone_reaches_the_target(score_of: Any, tmp_path: Path) -> None:
    report = write_wav(score_of(frames=240, sound=sound_with(DUO)), tmp_path / "a.wav")
    assert report.lufs == pytest.approx(-16, abs=0.3)
    assert report.true_peak_db <= -1
    assert (report.events, report.music > 20) == (0, True)


def test_music_gives_way_to_voices_and_has_its_gain(step: Any, score_of: Any) -> None:
    cry = step(25, cause="cry", duration=1.0)
    score = score_of([cry], frames=96, sound=sound_with(DUO))
    notes = notes_of(score)
    gain = yielding(Mix(duck_db=12), notes, 4 * SAMPLE_RATE)
    assert isinstance(gain, np.ndarray)
    assert gain.min() == pytest.approx(10 ** (-12 / 20), rel=0.02)

    def music(**mix: Any) -> Any:
        sound = score.sound.model_copy(update={"mix": Mix(**mix)})
        out = np.zeros((4 * SAMPLE_RATE, 2))
        mix_music(out, sound, notes, notes, 1.0, STEREO)
        return out

    free, ducked, louder = music(duck_db=0), music(duck_db=12), music(duck_db=0, music_db=6)
    during = slice(int(1.4 * SAMPLE_RATE), int(1.7 * SAMPLE_RATE))
    after = slice(int(3 * SAMPLE_RATE), None)
    assert np.allclose(ducked[during], free[during] * 10 ** (-12 / 20), rtol=0.03, atol=1e-4)
    assert np.allclose(ducked[after], free[after])
    assert np.allclose(louder, free * 10 ** (6 / 20))


def test_stems_of_parts_add_up_to_the_track(step: Any, score_of: Any, tmp_path: Path) -> None:
    events = [step(frame) for frame in (5, 30)] + [step(60, cause="cry", duration=0.5)]
    score = score_of(events, frames=96, sound=sound_with(DUO))
    report = write_wav(score, tmp_path / "track.wav")
    (tmp_path / "stems").mkdir()
    stems = list(
        write_stems(score, tmp_path / "stems", report.gain, report.curve, report.music_gain)
    )
    assert {stem.path.name for stem in stems} == {
        *("music_bass_music.wav", "music_pad_music.wav", "bug_footfall.wav", "bug_cry.wav")
    }
    whole = sum(read_stem(stem.path) for stem in stems)
    with wave.open(str(tmp_path / "track.wav")) as file:
        raw = np.frombuffer(file.readframes(file.getnframes()), np.uint8).reshape(-1, 3)
    words = np.zeros((len(raw), 4), np.uint8)
    words[:, 1:] = raw
    track = words.view("<i4")[:, 0].reshape(-1, 2) / 2**31
    assert np.abs(whole - track).max() < 10 ** (-80 / 20)


def test_parts_have_files_and_sides_of_their_own(step: Any, score_of: Any, tmp_path: Path) -> None:
    score = score_of([step(5)], frames=96, sound=sound_with(DUO, channels="5.1"))
    files = list(write_performers(score, tmp_path))
    assert [file.performer for file in files] == ["bug", "music bass", "music pad"]
    report = write_midi(score, tmp_path / "a.mid")
    assert len({(part.part.port, part.part.channel) for part in report.parts}) == 3
    track = write_wav(score, tmp_path / "a.wav")
    assert write_surround(score, tmp_path / "5.wav", "5.1", track)
    stereo = np.zeros((4 * SAMPLE_RATE, 2))
    bass = [note for note in notes_of(score) if note.event.who == "music bass"]
    mix_music(stereo, score.sound, [replace(note, send=0.0) for note in bass], (), 1.0, STEREO)
    left, right = np.sqrt((stereo**2).mean(axis=0))
    assert 20 * np.log10(left / right) == pytest.approx(7.66, abs=0.2)  # pan of -0.5
