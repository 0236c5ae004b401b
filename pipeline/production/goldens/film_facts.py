"""Film facts: container, decoded pictures and sound onsets of a film."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import av
import numpy as np
from numpy.typing import NDArray

from pipeline.errors import FilmingError, StoreError
from pipeline.production.goldens.golden_card import RESTORE_HINT
from pipeline.production.goldens.slate import slate_number
from pipeline.production.goldens.sound_onsets import (
    RATE,
    Onset,
    best_shift,
    onsets_of,
    unmatched_onsets,
)

_MAX_LISTED: Final = 6
"""Onsets that are listed one by one."""


@dataclass(frozen=True, slots=True)
class FilmFacts:
    """Facts of a decoded film.

    Attributes:
        container: fields of the container and its streams, as text.
        shown: number of the frame on each decoded picture, and its time [s] as a fraction.
        onsets: of the sound.
    """

    container: dict[str, str]
    shown: tuple[tuple[int, str], ...]
    onsets: tuple[Onset, ...]

    def encoded(self) -> str:
        """Return the facts as JSON."""
        shown = ", ".join(json.dumps(pair) for pair in self.shown)
        onsets = ",\n".join(f"  {json.dumps([o.time, o.rise])}" for o in self.onsets)
        container = json.dumps(self.container, indent=1)
        return f'{{"container": {container},\n"shown": [{shown}],\n"onsets": [\n{onsets}\n]}}\n'


def facts_of_film(path: Path) -> FilmFacts:
    """Decode a film whose pictures are slates.

    Raises:
        FilmingError: it cannot be decoded.
    """
    try:
        with av.open(str(path)) as container:
            facts = _container(container)
            shown = tuple(
                (
                    slate_number(frame.to_ndarray(format="gray")),
                    str(Fraction(frame.pts or 0) * (frame.time_base or 0)),
                )
                for frame in container.decode(video=0)
            )
        facts["pictures decoded"] = str(len(shown))
        heard = _decoded_sound(path) if "sound" in facts else np.zeros(0)
        return FilmFacts(facts, shown, onsets_of(heard))
    except (OSError, ValueError, av.FFmpegError) as error:
        raise FilmingError(f"{path.name}: could not be decoded: {error}") from error


def _container(container: Any) -> dict[str, str]:
    video = container.streams.video[0]
    context = video.codec_context
    facts = {
        "container": container.format.name,
        "picture": f"{context.name} {context.pix_fmt} {context.width}x{context.height}",
        "profile": str(video.profile),
        "rate": f"{video.average_rate} in units of {video.time_base} s",
        "frames told": str(video.frames),
        "lasts": f"{Fraction(video.duration or 0) * video.time_base} s",
        "colours": " ".join(
            str(int(getattr(context, name)))
            for name in ("colorspace", "color_primaries", "color_trc", "color_range")
        ),
        "reordered": str(bool(context.has_b_frames)),
    }
    if container.streams.audio:
        audio = container.streams.audio[0]
        facts["sound"] = f"{audio.codec_context.name} {audio.rate} Hz {audio.layout.name}"
        facts["sound begins"] = f"{Fraction(audio.start_time or 0) * audio.time_base} s"
        facts["sound lasts"] = f"{Fraction(audio.duration or 0) * audio.time_base} s"
    return facts


def _decoded_sound(path: Path) -> NDArray[np.float64]:
    """Return the sound of a film (N,) from time 0 on, the mean of all channels."""
    blocks = []
    with av.open(str(path)) as container:
        to_float = av.AudioResampler(format="fltp", rate=RATE)
        for block in container.decode(audio=0):
            for piece in to_float.resample(block):
                first = round(Fraction(piece.pts or 0) * (piece.time_base or 0) * RATE)
                blocks.append((first, piece.to_ndarray().mean(axis=0)))
    heard = np.zeros(max((first + values.size for first, values in blocks), default=0))
    for first, values in blocks:
        # Players drop samples before time 0.
        cut = max(-first, 0)
        heard[first + cut : first + values.size] = values[cut:]
    return heard


def read_film_facts(path: Path) -> FilmFacts:
    """Read the facts of a golden.

    Raises:
        StoreError: the file is damaged.
    """
    try:
        members: Any = json.loads(path.read_text(encoding="utf-8"))
        return FilmFacts(
            {str(name): str(fact) for name, fact in members["container"].items()},
            tuple((int(number), str(time)) for number, time in members["shown"]),
            tuple(Onset(float(time), float(rise)) for time, rise in members["onsets"]),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); {RESTORE_HINT}") from None


def film_differences(golden: FilmFacts, new: FilmFacts, frame: float) -> Iterator[str]:
    """Yield the differences of a film from its golden as text.

    Args:
        golden: expected facts.
        new: present facts.
        frame: duration of a frame [s].
    """
    for name in golden.container | new.container:
        then, now = (facts.container.get(name, "nothing") for facts in (golden, new))
        if then != now:
            yield f"{name}: {now}, the golden's {then}"
    for k, (old, one) in enumerate(zip(golden.shown, new.shown, strict=False), start=1):
        if old != one:
            yield (
                f"picture {k} shows frame {one[0]} at {one[1]} s, the golden's frame {old[0]} "
                f"at {old[1]} s"
            )
            break
    gone, added = unmatched_onsets(golden.onsets, new.onsets, frame / 2)
    if gone or added:
        late = best_shift(golden.onsets, new.onsets, frame)
        if late:
            frames = "a frame" if abs(late) == 1 else f"{abs(late)} frames"
            yield f"the sound is {frames} too {'late' if late > 0 else 'early'}"
        for fate, onsets in (("no longer", gone), ("newly", added)):
            if onsets:
                times = ", ".join(f"{onset.time:.3f}" for onset in onsets[:_MAX_LISTED])
                more = f" and {len(onsets) - _MAX_LISTED} more" if len(onsets) > _MAX_LISTED else ""
                yield f"{fate} heard at {times} s{more}"
