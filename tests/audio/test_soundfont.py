"""SoundFonts: notes on their samples, and one clear message for an unusable font."""

import importlib.util
import sys
from fractions import Fraction

import numpy as np
import pytest

from audio.errors import SoundFontError, SoundFontPlayerError
from audio.time_grid import sample_of_frame
from audio.wav_file import write_wav
from tests.audio.soundfont_writer import sf2

PLAYS = pytest.mark.skipif(
    importlib.util.find_spec("tinysoundfont") is None, reason="tinysoundfont is not installed"
)
CLICK = np.exp(-np.arange(2400) / 400) * np.cos(2 * np.pi * 1000 * np.arange(2400) / 48_000)


@pytest.fixture
def font(tmp_path):
    """Return a font of one click for one program and the drums."""
    path = tmp_path / "ein Klick – ü.sf2"
    path.write_bytes(sf2(CLICK, [(0, 0), (128, 0)]))
    return path


def test_without_tinysoundfont_the_message_says_what_to_install(
    font, step, score_of, tmp_path, monkeypatch
):
    # The player runs in a process of its own, with the import path of this one.
    elsewhere = [entry for entry in sys.path if not entry.endswith("site-packages")]
    monkeypatch.setattr(sys, "path", elsewhere)
    score = score_of([step(1)], sound={"soundfont": str(font)})
    with pytest.raises(SoundFontPlayerError, match="pip install --no-deps tinysoundfont"):
        write_wav(score, tmp_path / "a.wav")
    assert not (tmp_path / "a.wav").exists()


@PLAYS
@pytest.mark.parametrize("rate", [Fraction(24), Fraction(30_000, 1001), Fraction(60)])
def test_every_note_starts_on_its_sample(font, step, score_of, read_wav, tmp_path, rate):
    frames = [1, 9, 20, 31, 40]
    happened = [step(frame, who=f"w{frame}", azimuth=frame / 9 - 2) for frame in frames]
    config = {"soundfont": str(font), "voices": [{"pitch": "C4", "length": 0.1}]}
    report = write_wav(score_of(happened, 40, rate, config), tmp_path / "a.wav")
    sound = np.abs(read_wav(tmp_path / "a.wav")).max(axis=1)
    assert len(sound) == report.samples == sample_of_frame(41, rate)
    assert report.true_peak_db < -1
    for frame in frames:
        at = sample_of_frame(frame, rate)
        # A note's first sample is the click's first.
        assert sound[at] > 0.3 * sound[at : at + 400].max()
        assert sound[max(at - 40, 0) : at].max(initial=0) < 0.02 * sound[at]


@PLAYS
def test_the_soundfont_plays_the_notes_of_the_score(font, step, score_of, read_wav, tmp_path):
    def pitch(note):
        config = {"soundfont": str(font), "voices": [{"pitch": note}]}
        write_wav(score_of([step(1)], 24, sound=config), tmp_path / "p.wav")
        spectrum = np.abs(np.fft.rfft(read_wav(tmp_path / "p.wav")[:, 0]))
        return float(spectrum.argmax())

    assert pitch("C4") == pytest.approx(1000, rel=0.02)
    assert pitch("C5") == pytest.approx(2000, rel=0.02)


@PLAYS
def test_no_events_are_silent_and_drums_are_played(font, step, score_of, tmp_path):
    config = {"soundfont": str(font)}
    assert write_wav(score_of(sound=config), tmp_path / "a.wav").lufs == -np.inf
    config["voices"] = [{"drum": "claves"}]
    assert write_wav(score_of([step(1)], sound=config), tmp_path / "b.wav").lufs > -60
    # A second drummer is on a second port.
    both = score_of([step(1), step(9, who="other")], sound=config)
    assert write_wav(both, tmp_path / "c.wav").lufs > -60


@PLAYS
@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "is no SoundFont 2"),
        (b"RIFF\x04\0\0\0WAVE", "is no SoundFont 2"),
        (sf2(CLICK)[:300], "is cut short"),
        (sf2(CLICK).replace(b"phdr", b"xxxx"), "is a damaged SoundFont"),
        (sf2(CLICK).replace(b"shdr", b"xxxx"), "is a damaged SoundFont"),
        (sf2(CLICK, [(7, 0)]), "has no instrument"),
        (None, "is no file in"),
    ],
)
def test_an_invalid_soundfont_is_refused_by_name(step, score_of, tmp_path, data, said):
    path = tmp_path / "bad.sf2"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(SoundFontError, match=said) as refused:
        write_wav(score_of([step(1)], sound={"soundfont": str(path)}), tmp_path / "a.wav")
    assert str(path) in str(refused.value)
