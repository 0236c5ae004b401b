"""Films in VP9 and AV1, and their containers, checked with independent readers."""

from __future__ import annotations

import os
import wave
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import get_args

import av
import numpy as np
import pytest

from render.config.film import CONTAINERS as CONTAINERS_OF
from render.config.film import Codec, Film
from render.errors import EncodeError
from render.film_codecs import CODECS, CONTAINERS, RATE, find_codec
from render.film_encoder import write_film
from render.film_file import film_key

COUNT = 37
SIZE = (48, 64)
KINDS = [(codec, f".{end}") for codec in ("vp9", "av1") for end in CONTAINERS_OF[codec]]
FPS = Fraction(30000, 1001)

kinds = pytest.mark.parametrize(("codec", "suffix"), KINDS)


def pictures(flash: int = -1) -> Iterator[np.ndarray]:
    """Yield black frames with one of white."""
    for i in range(COUNT):
        yield np.full((*SIZE, 3), 255 if i == flash else 0, np.uint8)


def write_click(path: Path, onset: int, channels: int = 2) -> Path:
    """Write noise that begins at a sample, after silence, and outlasts the film."""
    sound = np.zeros(2 * RATE)
    noise = np.random.default_rng(0).choice([-0.8, 0.8], 960)
    sound[onset : onset + 960] = noise
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.repeat(sound[:, None], channels, 1) * 32767).astype("<i2").tobytes())
    return path


def decoded_sound(film: Path) -> tuple[Fraction, np.ndarray]:
    """Return the time of the first sample [s] and the sound (channels, N)."""
    to_rows = av.AudioResampler(format="fltp", rate=RATE)
    with av.open(str(film)) as container:
        blocks = [piece for block in container.decode(audio=0) for piece in to_rows.resample(block)]
    start = Fraction(blocks[0].pts or 0) * (blocks[0].time_base or 0)
    return start, np.concatenate([block.to_ndarray() for block in blocks], axis=1)


@kinds
def test_pictures_and_sound_are_where_they_belong(tmp_path: Path, codec: str, suffix: str) -> None:
    flash = 11
    onset = round(flash / FPS * RATE)
    wav = write_click(tmp_path / "s.wav", onset)
    film = tmp_path / f"f{suffix}"
    assert write_film(film, pictures(flash), FPS, wav, key="k|1", codec=codec) == COUNT
    assert film_key(film) == "k|1"
    with av.open(str(film)) as container:
        video = container.streams.video[0]
        assert video.average_rate == FPS
        packets = [packet for packet in container.demux(video) if packet.size]
        assert [p.pts for p in packets] == [p.dts for p in packets]
    with av.open(str(film)) as container:
        video = container.streams.video[0]
        shown = [
            (f.pts * f.time_base, f.to_ndarray(format="gray").mean())
            for f in container.decode(video)
        ]
        context = video.codec_context
        tags = (context.colorspace, context.color_primaries, context.color_trc, context.color_range)
        assert (tags, context.pix_fmt) == ((1, 1, 1, 1), "yuv420p")
        lengths = {s.duration * s.time_base for s in container.streams if s.duration is not None}
    # WebM has whole milliseconds, and lengths of no stream.
    tolerance = Fraction(1, 2000) if suffix == ".webm" else 0
    assert all(abs(time - i / FPS) <= tolerance for i, (time, _) in enumerate(shown))
    assert [i for i, (_, gray) in enumerate(shown) if gray > 128] == [flash]
    assert lengths == (
        set() if suffix == ".webm" else {COUNT / FPS, Fraction(round(COUNT / FPS * RATE), RATE)}
    )
    start, heard = decoded_sound(film)
    assert start == 0
    if suffix == ".webm":
        assert heard.shape == (2, round(COUNT / FPS * RATE))
    # The decoder's filters spread the noise by a sample or two; correlation finds its place.
    noise = np.random.default_rng(0).choice([-0.8, 0.8], 960)
    around = heard[0, onset - 480 : onset + 960 + 480]
    late = int(np.argmax(np.correlate(around, noise, "valid"))) - 480
    assert abs(late) <= 1


@kinds
def test_the_same_frames_give_the_same_bytes(tmp_path: Path, codec: str, suffix: str) -> None:
    frames = np.random.default_rng(0).integers(0, 256, (9, *SIZE, 3), dtype=np.uint8)
    wav = write_click(tmp_path / "s.wav", 100)
    films = [tmp_path / f"{name}{suffix}" for name in "ab"]
    for film in films:
        write_film(film, iter(frames), Fraction(24), wav, key="k", codec=codec)
    assert films[0].read_bytes() == films[1].read_bytes()


@kinds
def test_a_truncated_film_has_no_key(tmp_path: Path, codec: str, suffix: str) -> None:
    film = tmp_path / f"f{suffix}"
    write_film(
        film, pictures(), FPS, write_click(tmp_path / "s.wav", 0, channels=1), key="k", codec=codec
    )
    whole = film.read_bytes()
    assert film_key(film) == "k"
    for cut in (1, 100, len(whole) // 2, len(whole) - 20, len(whole) - 2, len(whole)):
        film.write_bytes(whole[: len(whole) - cut])
        assert film_key(film) is None, cut
    film.write_bytes(b"\0" * len(whole))
    assert film_key(film) is None


def test_encoders_are_silent(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for codec, suffix in KINDS:
        write_film(tmp_path / f"f{suffix}", pictures(), FPS, codec=codec)
    assert capfd.readouterr() == ("", "")


def test_the_language_and_the_encoders_have_the_same_codecs_and_containers() -> None:
    assert set(get_args(Codec)) == set(CODECS) == set(CONTAINERS_OF)
    assert {f".{end}" for its in CONTAINERS_OF.values() for end in its} == set(CONTAINERS)
    for codec, ends in CONTAINERS_OF.items():
        assert Film(codec=codec).resolved().suffix == f".{ends[0]}"


def test_a_container_that_does_not_hold_the_codec_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match="webm does not hold h264; write mp4, or codec: vp9 or av1"
    ):
        Film(container="webm")
    with pytest.raises(ValueError, match="mp4 does not hold prores; write mov, or codec: h264"):
        Film(preset="master", container="mp4")
    assert Film(preset="master", codec="av1", container="webm").resolved().suffix == ".webm"
    with pytest.raises(EncodeError, match="could not be encoded"):
        write_film(tmp_path / "f.webm", pictures(), FPS, codec="h264")


def test_a_size_that_the_encoder_of_av1_cannot_take_is_refused() -> None:
    assert Film(codec="av1", size=(32, 32)).resolved().size == (32, 32)
    with pytest.raises(ValueError, match="at least 32x32, is 64x16; write a larger size, or codec"):
        Film(codec="av1", size=(64, 16))


def test_a_missing_encoder_is_told_with_what_there_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = av.Codec

    def lacking(name: str, mode: str) -> av.Codec:
        return real("no such encoder" if name in ("libvpx-vp9", "aac") else name, mode)

    monkeypatch.setattr(av, "Codec", lacking)
    assert find_codec("av1") is CODECS["av1"]
    for codec, lacks in (("vp9", "libvpx-vp9"), ("h264", "aac")):
        wanted = rf"cannot encode {codec}: it lacks {lacks}; write prores or av1"
        with pytest.raises(EncodeError, match=wanted):
            write_film(tmp_path / "f.mp4", pictures(), FPS, codec=codec)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="no schedulers to choose from")
def test_encoding_leaves_the_priority_of_the_process(tmp_path: Path) -> None:
    before, seen = os.sched_getscheduler(0), list[int]()

    def watched() -> Iterator[np.ndarray]:
        for picture in pictures():
            seen.append(os.sched_getscheduler(0))
            yield picture

    write_film(tmp_path / "f.mp4", watched(), FPS, codec="av1")
    assert {*seen, os.sched_getscheduler(0)} == {before}
