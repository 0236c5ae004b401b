"""Synchrony of sound and video, measured by an independent meter."""

from __future__ import annotations

import wave
from fractions import Fraction
from pathlib import Path

import av
import av_drift_detector as meter
import numpy as np
import pytest

from render.film_codecs import RATE
from render.film_encoder import write_film

SIZE = (640, 360)
COUNT = 60


def write_late_film(
    folder: Path, fps: Fraction, delay: float, codec: str = "h264", suffix: str = ".mp4"
) -> Path:
    """Write the meter's own pattern as a film, its sound late by `delay` [s]."""
    rate = f"{fps.numerator}/{fps.denominator}"
    pattern = meter.PatternRenderer(fps=rate, width=SIZE[0], height=SIZE[1])

    def picture(i: int) -> np.ndarray:
        luma = np.frombuffer(pattern.render(i), np.uint8).reshape(SIZE[1], SIZE[0])
        full = np.clip((luma.astype(float) - 16) * 255 / 219, 0, 255)
        return np.repeat(full.astype(np.uint8)[..., None], 3, axis=2)

    count = round(COUNT / fps * RATE)
    sound = np.array(meter.synthesize_audio(count, fps=rate, delay=delay, music=False))
    with wave.open(str(folder / "s.wav"), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.clip(sound, -1, 1) * 32767).astype("<i2").tobytes())
    film = folder / f"f{suffix}"
    write_film(film, (picture(i) for i in range(COUNT)), fps, folder / "s.wav", codec=codec)
    return film


def late_ms(film: Path, fps: Fraction) -> float:
    """Return how late the sound of a film is [ms]."""
    reader = meter.StampReader()
    with av.open(str(film)) as container:
        for frame in container.decode(video=0):
            plane = frame.planes[0]
            time = float(frame.pts * frame.time_base)
            reader.read(bytes(plane), *SIZE, time, plane.line_size)
    with av.open(str(film)) as container:
        blocks = [frame for frame in container.decode(audio=0)]
    # One channel, so that rows and interleaved samples are the same.
    heard = np.concatenate([b.to_ndarray()[0] for b in blocks]).astype(np.float32)
    start = float(blocks[0].pts * blocks[0].time_base)
    report = meter.analyze_frames(
        reader.finish(),
        {"sample_rate": RATE, "start_time": start, "samples": heard},
        width=SIZE[0],
        height=SIZE[1],
        fps=f"{fps.numerator}/{fps.denominator}",
        capture="file",
    )
    summary = report["summary"]
    assert summary["measured"] > COUNT / 2
    assert summary["dropped_frames"] == summary["repeated_frames"] == 0
    assert summary["mean_ms"] is not None
    return summary["mean_ms"]


@pytest.mark.parametrize("fps", [Fraction(24), Fraction(30000, 1001)])
def test_sound_and_picture_are_synchronous(tmp_path: Path, fps: Fraction) -> None:
    assert abs(late_ms(write_late_film(tmp_path, fps, 0.0), fps)) < 1.0


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize(("codec", "suffix"), [("vp9", ".mp4"), ("vp9", ".webm"), ("av1", ".mp4")])
def test_other_codecs_are_as_synchronous(tmp_path: Path, codec: str, suffix: str) -> None:
    fps = Fraction(30000, 1001)
    assert abs(late_ms(write_late_film(tmp_path, fps, 0.0, codec, suffix), fps)) < 1.0


@pytest.mark.slow
def test_the_meter_detects_late_sound(tmp_path: Path) -> None:
    fps = Fraction(24)
    assert late_ms(write_late_film(tmp_path, fps, 0.010), fps) == pytest.approx(10.0, abs=1.0)
