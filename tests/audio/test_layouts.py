"""Layouts: sounds from their directions, in 5.1 and in B-format."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import get_args

import av
import numpy as np
import pytest

from audio.ambience import AMBIENCES
from audio.config.sound import LayoutName, Sound
from audio.layouts import LAYOUTS
from audio.surround_file import write_surround
from audio.wav_file import write_wav

DRY = {"room": "dry"}


def read(path: Path) -> tuple[np.ndarray, int]:
    """Return the samples (N, C) of a file as FFmpeg reads them, and its speaker bits."""
    with av.open(str(path)) as container:
        blocks = [frame.to_ndarray() for frame in container.decode(audio=0)]
        count = container.streams.audio[0].codec_context.channels
    data = path.read_bytes()
    (mask,) = struct.unpack_from("<I", data, data.index(b"fmt ") + 8 + 20)
    return np.concatenate(blocks, axis=1).reshape(-1, count) / 2.0**31, mask


@pytest.mark.parametrize("name", LAYOUTS)
@pytest.mark.parametrize("degrees", range(-180, 181, 15))
def test_power_is_the_same_from_all_around(name: str, degrees: int) -> None:
    gains = LAYOUTS[name].gains(np.radians(degrees))
    assert np.sum(gains**2) == pytest.approx(2.0 if name == "b-format" else 1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("degrees", "loudest"),
    [
        (0, {"centre"}),
        (30, {"right"}),
        (-30, {"left"}),
        (110, {"right side"}),
        (-100, {"left side"}),
        (180, {"left side", "right side"}),
    ],
)
def test_a_step_is_heard_from_its_side(
    step, score_of, tmp_path: Path, degrees: float, loudest: set[str]
) -> None:
    score = score_of([step(2, azimuth=np.radians(degrees))], 24, sound=DRY)
    track = write_wav(score, tmp_path / "a.wav")
    assert write_surround(score, tmp_path / "b.wav", "5.1", track)
    assert not write_surround(score, tmp_path / "b.wav", "5.1", track)
    sound, mask = read(tmp_path / "b.wav")
    assert (sound.shape, mask) == ((48_000, 6), 0x60F)
    power = (sound**2).sum(axis=0)
    channels = LAYOUTS["5.1"].channels
    heard = {channels[k] for k in np.flatnonzero(power > 0.4 * power.max())}
    assert heard == loudest
    assert power[3] == 0.0
    assert not sound[:2000].any()


def test_b_format_points_at_its_sound(step, score_of, tmp_path: Path) -> None:
    score = score_of([step(2, azimuth=np.radians(-50))], 24, sound=DRY)
    write_surround(score, tmp_path / "b.wav", "b-format", write_wav(score, tmp_path / "a.wav"))
    sound, mask = read(tmp_path / "b.wav")
    w, y, z, x = sound.T
    assert mask == 0
    # Left is positive in Y.
    assert np.degrees(np.arctan2((w * y).sum(), (w * x).sum())) == pytest.approx(50.0, abs=0.1)
    assert not z.any()


@pytest.mark.parametrize("layout", ["5.1", "b-format"])
def test_all_channels_stay_below_the_ceiling_and_have_the_place(
    step, score_of, tmp_path: Path, layout: str
) -> None:
    events = [step(1 + 3 * k, azimuth=0.1 * k, distance=2) for k in range(12)]
    score = score_of(events, 48, ambience=AMBIENCES["rain"])
    write_surround(score, tmp_path / "b.wav", layout, write_wav(score, tmp_path / "a.wav"))
    sound, _ = read(tmp_path / "b.wav")
    assert np.abs(sound).max() < 10 ** (-1 / 20)
    level = 10 * np.log10((sound[48_000 + 3000 :] ** 2).mean(axis=0) + 1e-12)
    silent = {"5.1": [2, 3], "b-format": [2]}[layout]
    heard = [k for k in range(sound.shape[1]) if k not in silent]
    assert min(level[heard]) > -60.0


def test_every_layout_has_a_word() -> None:
    assert set(get_args(LayoutName)) == set(LAYOUTS)


def test_channels_are_words_and_soundfonts_are_stereo() -> None:
    assert Sound.model_validate({"channels": 5.1}).channels == "5.1"
    with pytest.raises(ValueError, match="channels"):
        Sound.model_validate({"channels": "7.1"})
    with pytest.raises(ValueError, match="plays in stereo"):
        Sound.model_validate({"channels": "5.1", "soundfont": "a.sf2"})
