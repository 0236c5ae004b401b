"""Film stage: frames and their sound as a film."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pipeline.production.run.frame_ranges import contiguous, counted, described
from pipeline.production.run.progress import Stage, stage
from pipeline.production.run.scene_run import SceneRun
from render.color import developed, developed16
from render.film_encoder import CODECS, Picture, film_key, write_film
from render.image_files import read_exr, read_png


def make_film(run: SceneRun, frames: tuple[int, ...], keys: dict[int, str]) -> None:
    """Encode the frames and their sound into a film."""
    order, outputs = run.order, run.outputs
    whole = len(frames) == order.scene.n_frames
    suffix = order.scene.film.resolved().suffix
    place = run.whole_film if whole else outputs.film(described(frames), suffix)
    sound = outputs.wav if order.sound and contiguous(frames) else None
    if order.sound and sound is None:
        run.reporter.note("film: frames with gaps between them have no sound")
    key = _film_key(run, [keys[frame] for frame in frames], sound, frames[0])
    with stage(run.reporter, "film", len(frames), "frames") as current:
        if film_key(place) == key:
            current.result = f"{place.name} is up to date"
            return
        rate = order.scene.rate
        began_at = (frames[0] - 1) / rate
        write_film(place, _pictures(run, frames, current), rate, sound, began_at, key)
        run.record_time(current)
        current.result = f"{place.name}, {counted(len(frames))}" + (", with sound" if sound else "")


def _pictures(run: SceneRun, frames: tuple[int, ...], current: Stage) -> Iterator[Picture]:
    """Yield the pictures of `frames` at the bit depth of the film's codec, and report each."""
    film = run.order.scene.film.resolved()
    deep = CODECS[film.suffix].bits == 16
    for done, frame in enumerate(frames):
        current.advance(done)
        path = run.outputs.frame(frame, film.format)
        if film.format == "png":
            picture = read_png(path)
            # 257 = 65535 / 255, so that white stays white.
            yield picture.astype(np.uint16) * 257 if deep else picture
        else:
            light = read_exr(path)
            develop = developed16 if deep else developed
            yield develop(light, film.exposure)


def _film_key(run: SceneRun, keys: list[str], sound: Path | None, first: int) -> str:
    state = hashlib.blake2b(digest_size=20)
    state.update("\n".join([str(run.order.scene.rate), str(first), *keys]).encode())
    if sound is not None:
        state.update(sound.read_bytes())
    return state.hexdigest()
