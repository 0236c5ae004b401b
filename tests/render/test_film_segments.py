"""Films of several segments: joined ones are those of one process, and their times are exact."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import wave
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from render.config.film import CONTAINERS as CONTAINERS_OF
from render.errors import EncodeError
from render.film_codecs import CODECS, CONTAINERS, RATE
from render.film_encoder import join_film, write_film
from render.film_file import film_key
from render.film_segments import (
    SEGMENT_SECONDS,
    Picture,
    opened_segment,
    segment_length,
    segment_suffix,
    video_frame,
    video_stream,
    write_segment,
)
from render.film_sound import SoundTrack, read_wav

KINDS = [(codec, f".{end}") for codec, ends in CONTAINERS_OF.items() for end in ends]
FPS = Fraction(30000, 1001)
COUNT, LENGTH = 15, 7
"""The last segment has one picture."""

kinds = pytest.mark.parametrize(("codec", "suffix"), KINDS)


def pictures(codec: str, first: int = 0, end: int = COUNT) -> list[Picture]:
    """Return a pattern that moves, from one picture to before another."""
    values = np.random.default_rng(1).integers(0, 256, (12, 16 + COUNT, 3), dtype=np.uint8)
    wide = np.kron(values, np.ones((4, 4, 1), np.uint8)).astype(np.uint8)
    shown = [wide[:, 4 * i : 4 * i + 64] for i in range(first, end)]
    return shown if CODECS[codec].bits == 8 else [p.astype(np.uint16) * 257 for p in shown]


def encoded(folder: Path, codec: str, length: int = LENGTH, fps: Fraction = FPS) -> list[Path]:
    """Encode segments one by one, the last one first, as machines of a farm may."""
    starts = range(0, COUNT, length)
    files = [folder / f"{start}{segment_suffix(codec)}" for start in starts]
    for start, file in reversed(list(zip(starts, files, strict=True))):
        write_segment(file, pictures(codec, start, min(start + length, COUNT)), fps, codec)
    return files


@pytest.fixture
def noise(tmp_path: Path) -> Path:
    path = tmp_path / "s.wav"
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE)
        values = np.random.default_rng(0).integers(-9000, 9000, (RATE, 2), dtype=np.int16)
        file.writeframes(values.tobytes())
    return path


def shown_times(film: Path) -> list[Fraction]:
    with av.open(str(film)) as container:
        return [Fraction(f.pts or 0) * f.time_base for f in container.decode(video=0)]


@pytest.mark.sample(3)
@kinds
def test_joined_segments_are_the_film_of_one_process(
    tmp_path: Path, noise: Path, codec: str, suffix: str
) -> None:
    whole, joined = tmp_path / f"whole{suffix}", tmp_path / f"joined{suffix}"
    frames = iter(pictures(codec))
    assert write_film(whole, frames, FPS, noise, key="k", codec=codec, length=LENGTH) == COUNT
    files = encoded(tmp_path, codec)
    assert join_film(joined, iter(files), FPS, noise, key="k", codec=codec) == COUNT
    assert whole.read_bytes() == joined.read_bytes()
    # Of some segments there are files, the others are pictures.
    mixed = [pictures(codec, 0, LENGTH), files[1], pictures(codec, 2 * LENGTH)]
    join_film(joined, mixed, FPS, noise, key="k", codec=codec)
    assert whole.read_bytes() == joined.read_bytes()
    assert film_key(joined) == "k"


@kinds
def test_times_of_segments_are_exact(tmp_path: Path, noise: Path, codec: str, suffix: str) -> None:
    film = tmp_path / f"f{suffix}"
    write_film(film, pictures(codec), FPS, noise, codec=codec, length=LENGTH)
    tolerance = CONTAINERS[suffix].tick / 2
    times = shown_times(film)
    assert len(times) == COUNT
    assert all(abs(time - i / FPS) <= tolerance for i, time in enumerate(times))
    with av.open(str(film)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
    assert [p.pts for p in packets] == [p.dts for p in packets]
    keys = [i for i, packet in enumerate(packets) if packet.is_keyframe]
    assert {0, LENGTH, 2 * LENGTH} <= set(keys)
    if suffix != ".webm":
        with av.open(str(film)) as container:
            video, audio = container.streams.video[0], container.streams.audio[0]
            assert video.start_time == audio.start_time == 0
            assert video.duration * video.time_base == COUNT / FPS
            assert audio.duration * audio.time_base == Fraction(round(COUNT / FPS * RATE), RATE)
        assert film.read_bytes().count(b"elst") == 2  # one a track, none of them shifts


@kinds
def test_a_film_of_one_segment_is_as_if_encoded_into_its_container(
    tmp_path: Path, noise: Path, codec: str, suffix: str
) -> None:
    film, other = tmp_path / f"f{suffix}", tmp_path / f"g{suffix}"
    write_film(film, pictures(codec), FPS, noise, key="k", codec=codec)
    form, its = CONTAINERS[suffix], CODECS[codec]
    options = {"fflags": "+bitexact", **form.options(FPS)}
    with av.open(str(other), "w", format=form.name, options=options) as container:
        container.metadata["comment"] = "k"
        video = video_stream(container, (64, 48), FPS, its)
        track = SoundTrack(container, read_wav(noise), its.sound)
        for count, picture in enumerate(pictures(codec)):
            container.mux(video.encode(video_frame(picture, count, FPS, its)))
            track.encode_until((count + 1) / FPS)
        container.mux(video.encode(None))
        track.finish_at(COUNT / FPS)
    assert film.read_bytes() == other.read_bytes()
    assert COUNT < segment_length(FPS)


def test_segments_have_whole_distances_of_key_frames() -> None:
    for fps in (Fraction(24), FPS, Fraction(25), Fraction(15, 2), Fraction(1, 4)):
        assert segment_length(fps) == SEGMENT_SECONDS * max(1, round(fps))


def test_a_segment_of_other_extradata_is_refused(tmp_path: Path) -> None:
    film = tmp_path / "f.mp4"
    write_film(film, pictures("h264"), FPS, key="old")
    first, second, _ = encoded(tmp_path, "h264")
    with opened_segment(first, FPS) as (form, _):
        assert form.extradata
    data = second.read_bytes()
    assert data.count(form.extradata) == 1
    changed = bytearray(form.extradata)
    changed[3] += 1  # the level
    second.write_bytes(data.replace(form.extradata, bytes(changed)))
    with pytest.raises(EncodeError, match="from frame 8 on was encoded by another version"):
        join_film(film, [first, second], FPS)
    assert film_key(film) == "old"


def test_segments_that_do_not_belong_together_are_refused(tmp_path: Path) -> None:
    film = tmp_path / "f.mp4"
    (one, _, last), small = encoded(tmp_path, "vp9"), tmp_path / "small.mp4"
    write_segment(small, [np.zeros((48, 32, 3), np.uint8)], FPS, "vp9")
    with pytest.raises(EncodeError, match="frame 8 is 32x48 and the first 64x48"):
        join_film(film, [one, small], FPS, codec="vp9")
    with pytest.raises(EncodeError, match="is not of 25 frames a second; encode it again"):
        join_film(film, [one, last], Fraction(25), codec="vp9")
    with pytest.raises(EncodeError, match="a segment is vp9, not h264; encode it again"):
        join_film(film, [one], FPS)
    write_segment(small, pictures("av1"), FPS, "av1")
    with pytest.raises(EncodeError, match="from frame 8 on was encoded by another version"):
        join_film(film, [one, small], FPS, codec="vp9")
    assert not film.exists()


def test_a_damaged_segment_leaves_the_old_film(tmp_path: Path, noise: Path) -> None:
    film = tmp_path / "f.mp4"
    write_film(film, pictures("h264"), FPS, key="old")
    first, second, _ = encoded(tmp_path, "h264")
    second.write_bytes(second.read_bytes()[:-200])
    for segments in ([first, second], [first, tmp_path / "none.mp4"], [noise]):
        with pytest.raises(EncodeError):
            join_film(film, segments, FPS)
    assert film_key(film) == "old"
    assert not list(tmp_path.glob(".*"))


def test_a_picture_of_another_size_is_told_by_its_number(tmp_path: Path) -> None:
    film = tmp_path / "f.mp4"
    small = np.zeros((48, 32, 3), np.uint8)
    for at, first in ((7, "the first"), (9, "frame 8")):
        frames = [*pictures("h264", 0, at), small]
        with pytest.raises(EncodeError, match=rf"frame {at + 1} is 32x48 and {first} 64x48"):
            write_film(film, frames, FPS, length=LENGTH)
    assert not list(tmp_path.iterdir())


def test_pictures_are_read_when_their_segment_is_due(tmp_path: Path) -> None:
    written: list[int] = []

    def watched() -> Iterator[Picture]:
        for number, picture in enumerate(pictures("prores")):
            written.append(len(list(tmp_path.glob(".*segment*"))))
            yield picture
            assert number < COUNT

    write_film(tmp_path / "f.mov", watched(), FPS, codec="prores", length=LENGTH)
    # The file of one segment at a time, and none is left.
    assert max(written) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["f.mov"]


ENCODE = """
import hashlib, sys
from fractions import Fraction
from pathlib import Path
import numpy as np
from render.film_segments import write_segment
values = np.random.default_rng(1).integers(0, 256, (270, 496, 3), dtype=np.uint8)
pictures = [np.ascontiguousarray(values[:, 2 * i : 2 * i + 480]) for i in range(6)]
write_segment(Path(sys.argv[1]), pictures, Fraction(24), "h264")
"""


@pytest.mark.slow
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="fills memory by a variable of glibc")
def test_a_film_does_not_depend_on_what_memory_held_before(tmp_path: Path) -> None:
    made = set()
    for filling in ("0", "1", "2"):
        path = tmp_path / f"{filling}.mp4"
        subprocess.run(
            [sys.executable, "-c", ENCODE, str(path)],
            env={**os.environ, "MALLOC_PERTURB_": filling},
            check=True,
        )
        made.add(path.read_bytes())
    assert len(made) == 1
