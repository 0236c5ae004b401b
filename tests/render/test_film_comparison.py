"""Film comparison: what an encoder does to pictures and sound passes, all else is told."""

from __future__ import annotations

import wave
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from render.film_codecs import RATE
from render.film_comparison import picture_differences, sound_differences
from render.film_encoder import write_film

FPS = Fraction(24)
SIZE = (48, 64, 3)
RNG = np.random.default_rng(4)


def smooth(count: int = 12) -> np.ndarray:
    """Return frames of a pattern that moves, as rendered ones do."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    waves = [np.sin((x + 5 * k) / 9)[..., None] * np.cos(y / 7)[..., None] for k in range(count)]
    return np.stack([np.repeat(127 + 110 * w, 3, axis=2) for w in waves]).astype(np.uint8)


def noise(rng: np.random.Generator = RNG) -> np.ndarray:
    return rng.integers(0, 2, (12, *SIZE), dtype=np.uint8) * 255


CODEC = {".mp4": "h264", ".mov": "prores", ".webm": "vp9"}
SUFFIXES = list(CODEC)


def film_of(
    path: Path, frames: np.ndarray, sound: Path | None = None, codec: str | None = None
) -> Path:
    pictures = deep(frames) if path.suffix == ".mov" else list(frames)
    write_film(path, pictures, FPS, sound, codec=codec or CODEC[path.suffix])
    return path


def deep(frames: np.ndarray) -> list[np.ndarray]:
    return [frame.astype(np.uint16) * 257 for frame in frames]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("frames", [smooth(), noise()], ids=["smooth", "noise"])
def test_a_film_shows_its_frames(tmp_path: Path, suffix: str, frames: np.ndarray) -> None:
    film = film_of(tmp_path / f"a{suffix}", frames)
    given = deep(frames) if suffix == ".mov" else frames
    assert picture_differences(film, given, FPS, CODEC[suffix]) == []
    assert picture_differences(film, [None] * 12, FPS, CODEC[suffix]) == []


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_other_pictures_are_told(tmp_path: Path, suffix: str) -> None:
    frames = smooth()
    film = film_of(tmp_path / f"a{suffix}", frames)
    frames[4, :16, 32:48] += 12
    frames[[7, 9]] = frames[[9, 7]]
    given = deep(frames) if suffix == ".mov" else list(frames)
    (text,) = picture_differences(film, given, FPS, CODEC[suffix])
    assert text.startswith("pictures 5, 8, 10 are unlike the frame, by up to ")
    given[7] = given[9] = None
    (text,) = picture_differences(film, given, FPS, CODEC[suffix])
    assert text == "picture 5 is unlike the frame, by up to 10 levels of 255"


@pytest.mark.parametrize("codec", ["vp9", "av1"])
@pytest.mark.parametrize(
    "frames", [smooth(36), noise(np.random.default_rng(1))], ids=["smooth", "noise"]
)
def test_films_of_other_codecs_are_as_their_frames_and_sound(
    tmp_path: Path, codec: str, frames: np.ndarray
) -> None:
    sound = wav_of(tmp_path / "s.wav", steps())
    film = film_of(tmp_path / "a.mp4", frames, sound, codec)
    assert picture_differences(film, frames, FPS, codec) == []
    assert sound_differences(film, sound) == []
    assert picture_differences(film, frames[::-1], FPS, codec) != []


def test_missing_and_added_pictures_are_told(tmp_path: Path) -> None:
    frames = list(smooth())
    film = film_of(tmp_path / "a.mp4", np.stack(frames))
    for given in (frames[:-2], [*frames, frames[0]]):
        expected = f"shows 12 pictures instead of {len(given)}"
        assert picture_differences(film, given, FPS) == [expected]
        assert picture_differences(film, [None] * len(given), FPS) == [expected]


def test_another_rate_and_another_size_are_told(tmp_path: Path) -> None:
    frames = smooth()
    film = film_of(tmp_path / "a.mp4", frames)
    (text,) = picture_differences(film, frames, Fraction(25))
    assert text == "pictures 2, 3, 4, 5 and 7 more are not at the time of the frame"
    (text,) = picture_differences(film, frames[:, :46], FPS)
    assert text == "pictures 1, 2, 3, 4 and 8 more are of another size or format than the frame"


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_damaged_data_are_told(tmp_path: Path, share: float) -> None:
    frames = noise()
    film = film_of(tmp_path / "a.mp4", frames)
    assert picture_differences(film, frames, FPS) == []
    data = bytearray(film.read_bytes())
    # In the middle of a picture's data: their last bytes are a small part of it.
    with av.open(str(film)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
    packet = packets[int(len(packets) * share)]
    at = (packet.pos or 0) + packet.size // 2
    data[at : at + 50] = bytes(byte ^ 0xFF for byte in data[at : at + 50])
    film.write_bytes(data)
    assert picture_differences(film, frames, FPS) != []


def test_a_film_whose_index_is_damaged_is_told(tmp_path: Path) -> None:
    film, sound = tmp_path / "a.mp4", wav_of(tmp_path / "s.wav", steps())
    film_of(film, smooth(), sound)
    whole = film.read_bytes()
    for kind in (b"avc1", b"stsd", b"minf", b"stsz", b"stco", b"trak"):
        film.write_bytes(whole.replace(kind, b"none"))
        assert picture_differences(film, smooth(), FPS), kind
        assert sound_differences(film, sound) or kind == b"avc1", kind


def test_what_is_no_film_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"no film")
    (text,) = picture_differences(tmp_path / "a.mp4", [], FPS)
    assert text.startswith("cannot be decoded (")
    (text,) = sound_differences(tmp_path / "a.mp4", None)
    assert text.startswith("its sound cannot be decoded (")


def steps(seconds: float = 1.5) -> np.ndarray:
    """Return clicks with long tails over silence, (N, 2)."""
    samples = np.zeros((int(RATE * seconds), 2))
    for start in (0.2, 0.55, 1.1):
        at, tail = int(start * RATE), np.exp(-np.arange(6000) / 900)
        samples[at : at + 6000] += (tail * np.sin(np.arange(6000) / 7))[:, None] * [0.6, 0.4]
    return samples


def wav_of(path: Path, samples: np.ndarray) -> Path:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())
    return path


@pytest.mark.sample(4)
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "samples",
    [steps(), RNG.normal(0, 0.3, (72000, 2)), RNG.normal(0, 0.01, (72000, 2)), np.zeros((9, 2))],
    ids=["steps", "noise", "soft noise", "silence"],
)
def test_a_film_has_the_sound_of_its_file(tmp_path: Path, suffix: str, samples: np.ndarray) -> None:
    sound = wav_of(tmp_path / "s.wav", samples)
    film = film_of(tmp_path / f"a{suffix}", smooth(36), sound)
    assert sound_differences(film, sound) == []


def test_the_sound_of_a_part_is_compared_from_its_start(tmp_path: Path) -> None:
    sound = wav_of(tmp_path / "s.wav", steps())
    write_film(tmp_path / "a.mp4", list(smooth()), FPS, sound, Fraction(12, 24))
    assert sound_differences(tmp_path / "a.mp4", sound, Fraction(12, 24)) == []
    (text,) = sound_differences(tmp_path / "a.mp4", sound)
    assert text.startswith("its sound differs from s.wav from 0.0 s on")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    ("start", "change"),
    [(0.5, 0.0), (1.1, -1.0), (0.8, "added")],
    ids=["silenced", "inverted", "added"],
)
def test_another_sound_is_told(
    tmp_path: Path, suffix: str, start: float, change: float | str
) -> None:
    sound = wav_of(tmp_path / "s.wav", steps())
    film = film_of(tmp_path / f"a{suffix}", smooth(36), sound)
    samples, at = steps(), slice(round(start * RATE), round((start + 0.2) * RATE))
    if change == "added":
        samples[at] = steps()[int(0.2 * RATE) : int(0.4 * RATE)]
    else:
        samples[at] *= change
    (text,) = sound_differences(film, wav_of(tmp_path / "s.wav", samples))
    assert text.startswith(f"its sound differs from s.wav from {start:.1f} s on: ")


def test_a_shift_of_two_milliseconds_is_told(tmp_path: Path) -> None:
    sound = wav_of(tmp_path / "s.wav", RNG.normal(0, 0.3, (72000, 2)))
    film = film_of(tmp_path / "a.mov", smooth(36), sound)
    with wave.open(str(sound)) as file:
        data = file.readframes(72000)
    shifted = np.roll(np.frombuffer(data, "<i2").reshape(-1, 2) / 32767, 96, axis=0)
    (text,) = sound_differences(film, wav_of(tmp_path / "s.wav", shifted))
    assert text.startswith("its sound differs from s.wav from 0.0 s on")


def test_a_missing_and_an_added_sound_are_told(tmp_path: Path) -> None:
    sound = wav_of(tmp_path / "s.wav", steps())
    silent, loud = (tmp_path / name for name in ("silent.mp4", "loud.mp4"))
    film_of(silent, smooth(36))
    film_of(loud, smooth(36), sound)
    assert sound_differences(silent, sound) == ["has no sound"]
    assert sound_differences(loud, None) == ["has sound, and was made without"]
