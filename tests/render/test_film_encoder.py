"""Film encoder, checked with independent readers."""

from __future__ import annotations

import wave
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from render.errors import EncodeError
from render.film_codecs import RATE
from render.film_encoder import write_film
from render.film_file import film_key

RATES = [Fraction(24), Fraction(25), Fraction(30000, 1001), Fraction(60), Fraction(15, 2)]
COUNT = 37


def patches(color: tuple[int, int, int]) -> np.ndarray:
    return np.full((48, 64, 3), color, np.uint8)


def write_wave(path: Path, samples: np.ndarray) -> Path:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.repeat(samples[:, None], 2, 1) * 32767).astype("<i2").tobytes())
    return path


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("seconds", [0.2, 9.0])
def test_times_and_lengths_are_exact(tmp_path: Path, fps: Fraction, seconds: float) -> None:
    sound = write_wave(tmp_path / "s.wav", np.zeros(int(RATE * seconds)))
    film = tmp_path / "f.mp4"
    assert (
        write_film(film, (patches((i, 0, 0)) for i in range(COUNT)), fps, sound, key="k|1") == COUNT
    )
    assert film_key(film) == "k|1"
    with av.open(str(film)) as container:
        video, audio = container.streams.video[0], container.streams.audio[0]
        assert (video.frames, video.average_rate) == (COUNT, fps)
        shown = [f.pts * f.time_base for f in container.decode(video)]
        assert shown == [i / fps for i in range(COUNT)]
        assert video.duration * video.time_base == COUNT / fps
        assert audio.duration * audio.time_base == pytest.approx(float(COUNT / fps), abs=1 / RATE)
        assert audio.start_time == 0
        assert audio.rate == RATE


def test_colours_survive_encoding_and_are_tagged(tmp_path: Path) -> None:
    colors = [(200, 40, 40), (40, 160, 60), (30, 60, 190), (128, 128, 128), (255, 255, 255)]
    film = tmp_path / "f.mp4"
    write_film(film, (patches(c) for c in colors), Fraction(24))
    with av.open(str(film)) as container:
        stream = container.streams.video[0]
        context = stream.codec_context
        assert (context.colorspace, context.color_range) == (1, 1)
        assert (context.color_primaries, context.color_trc) == (1, 1)
        assert context.pix_fmt == "yuv420p"
        for frame, color in zip(container.decode(stream), colors, strict=True):
            y, u, v = (float(np.frombuffer(p, np.uint8)[: p.width].mean()) for p in frame.planes)
            # The inverse of BT.709's matrix at limited range, written out by hand.
            luma, cb, cr = (y - 16) / 219, (u - 128) / 224, (v - 128) / 224
            red, blue = luma + 1.5748 * cr, luma + 1.8556 * cb
            green = (luma - 0.2126 * red - 0.0722 * blue) / 0.7152
            np.testing.assert_allclose(np.array([red, green, blue]) * 255, color, atol=4)


def test_the_same_frames_give_the_same_bytes(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).integers(0, 256, (9, 48, 64, 3), dtype=np.uint8)
    for name in ("a.mp4", "b.mp4"):
        write_film(tmp_path / name, iter(frames), Fraction(24), key="k")
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mp4", "b.mp4"]


def test_frames_are_shown_in_the_order_of_decoding(tmp_path: Path) -> None:
    film = tmp_path / "f.mp4"
    write_film(film, (patches((5 * i, 0, 0)) for i in range(COUNT)), Fraction(24))
    with av.open(str(film)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
        assert [p.pts for p in packets] == [p.dts for p in packets]
    head = film.read_bytes()
    assert head.index(b"moov") < head.index(b"mdat")


@pytest.mark.parametrize("fps", [Fraction(24), Fraction(30000, 1001), Fraction(60)])
def test_sound_and_video_agree_within_a_millisecond(tmp_path: Path, fps: Fraction) -> None:
    flashes = [12, 31]
    sound = np.zeros(RATE * 3)
    for frame in flashes:
        start = round(frame / fps * RATE)
        sound[start : start + 480] = 0.8 * np.sign(np.sin(np.arange(480) * 0.9))
    wav = write_wave(tmp_path / "s.wav", sound)
    film = tmp_path / "f.mp4"
    pictures = (patches((255,) * 3 if i in flashes else (0,) * 3) for i in range(48))
    write_film(film, pictures, fps, wav)
    with av.open(str(film)) as container:
        bright = [
            float(f.pts * f.time_base)
            for f in container.decode(video=0)
            if np.frombuffer(f.planes[0], np.uint8)[:64].mean() > 128
        ]
    with av.open(str(film)) as container:
        decoded = [(f.pts, f.to_ndarray()[0]) for f in container.decode(audio=0)]
    assert decoded[0][0] == 0
    heard = np.concatenate([block for _, block in decoded])
    for seen in bright:
        # AAC spreads a little sound before an onset; half of the peak is the onset itself.
        window = slice(max(0, round((seen - 0.1) * RATE)), round((seen + 0.1) * RATE))
        onset = window.start + int(np.argmax(np.abs(heard[window]) > 0.4))
        assert abs(onset / RATE - seen) < 1e-3
    assert len(bright) == len(flashes)


def test_a_failed_encoding_says_why_and_keeps_the_old_film(tmp_path: Path) -> None:
    film = tmp_path / "f.mp4"
    write_film(film, [patches((1, 2, 3))], Fraction(24), key="old")
    with pytest.raises(EncodeError, match="no frame"):
        write_film(film, [], Fraction(24))
    with pytest.raises(EncodeError, match="frame 2 is 32x48"):
        write_film(film, [patches((0, 0, 0)), np.zeros((48, 32, 3), np.uint8)], Fraction(24))
    with pytest.raises(EncodeError, match=r"\.mp4"):
        write_film(tmp_path / "f.avi", [patches((0, 0, 0))], Fraction(24))
    with pytest.raises(EncodeError, match="could not be encoded"):
        write_film(film, [patches((0, 0, 0))], Fraction(24), tmp_path / "none.wav")
    assert film_key(film) == "old"
    assert film_key(tmp_path / "none.mp4") is None
    assert [p.name for p in tmp_path.iterdir()] == ["f.mp4"]


def test_sound_of_a_part_starts_with_the_part(tmp_path: Path) -> None:
    # Silence for frames 1 to 6, then a tone: a part from frame 7 on begins with the tone.
    tone = np.sin(np.arange(48000) * (2 * np.pi * 440 / 48000)) * 0.5
    tone[: 6 * 2000] = 0.0
    wav = tmp_path / "s.wav"
    with wave.open(str(wav), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(48000)
        file.writeframes((tone * 32767).astype("<i2").tobytes())
    loud = {}
    for first in (1, 7):
        film = tmp_path / f"{first}.mp4"
        pictures = [patches((0, 0, 0))] * 6
        write_film(film, pictures, Fraction(24), wav, Fraction(first - 1, 24))
        with av.open(str(film)) as container:
            heard = np.concatenate([f.to_ndarray() for f in container.decode(audio=0)], axis=1)
        loud[first] = float(np.abs(heard[0, 2000:10000]).mean())
    assert loud[1] < 0.01
    assert loud[7] > 0.2


def test_a_truncated_film_has_no_key(tmp_path: Path) -> None:
    film = tmp_path / "f.mp4"
    write_film(film, [patches((i, 0, 0)) for i in range(COUNT)], Fraction(24), key="k")
    whole = film.read_bytes()
    assert film_key(film) == "k"
    for cut in (1, 100, len(whole) // 2, len(whole) - 20):
        film.write_bytes(whole[:-cut])
        assert film_key(film) is None, cut
