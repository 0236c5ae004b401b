"""Film facts: what a film is, decoded again: its container, its pictures, when it sounds."""

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
from pipeline.production.goldens.frame_slates import number_on
from pipeline.production.goldens.golden_card import AGAIN
from pipeline.production.goldens.onsets import Onset, best_shift, onsets_of, unmatched

RATE: Final = 48_000


@dataclass(frozen=True, slots=True)
class FilmFacts:
    """What a film is.

    Attributes:
        container: its fields, and those of its streams, as words.
        shown: of each decoded picture, which frame it shows and when [s], as a fraction in words.
        onsets: when sounds begin.
    """

    container: dict[str, str]
    shown: tuple[tuple[int, str], ...]
    onsets: tuple[Onset, ...]

    def encoded(self) -> str:
        """Return them as JSON."""
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
                    number_on(frame.to_ndarray(format="gray")),
                    str(Fraction(frame.pts or 0) * (frame.time_base or 0)),
                )
                for frame in container.decode(video=0)
            )
        facts["pictures decoded"] = str(len(shown))
        heard = _heard(path) if "sound" in facts else np.zeros(0)
        return FilmFacts(facts, shown, onsets_of(heard, RATE))
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


def _heard(path: Path) -> NDArray[np.float64]:
    """Return the sound of a film (N,) from time 0 on, all channels together."""
    blocks = []
    with av.open(str(path)) as container:
        to_float = av.AudioResampler(format="fltp", rate=RATE)
        for block in container.decode(audio=0):
            for piece in to_float.resample(block):
                first = round(Fraction(piece.pts or 0) * (piece.time_base or 0) * RATE)
                blocks.append((first, piece.to_ndarray().mean(axis=0)))
    heard = np.zeros(max((first + values.size for first, values in blocks), default=0))
    for first, values in blocks:
        # What comes before time 0 is not played.
        cut = max(-first, 0)
        heard[first + cut : first + values.size] = values[cut:]
    return heard


def read_facts(path: Path) -> FilmFacts:
    """Read the facts of a golden.

    Raises:
        StoreError: they are damaged.
    """
    try:
        words: Any = json.loads(path.read_text(encoding="utf-8"))
        return FilmFacts(
            {str(name): str(fact) for name, fact in words["container"].items()},
            tuple((int(number), str(time)) for number, time in words["shown"]),
            tuple(Onset(float(time), float(rise)) for time, rise in words["onsets"]),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); {AGAIN}") from None


def differences(golden: FilmFacts, new: FilmFacts, frame: float) -> Iterator[str]:
    """Give what differs, in words.

    Args:
        golden: what is to be.
        new: what is.
        frame: how long one is [s].
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
    gone, added = unmatched(golden.onsets, new.onsets, frame / 2)
    if gone or added:
        late = best_shift(golden.onsets, new.onsets, frame)
        if late:
            frames = "a frame" if abs(late) == 1 else f"{abs(late)} frames"
            yield f"the sound is {frames} too {'late' if late > 0 else 'early'}"
        for fate, some in (("no longer", gone), ("newly", added)):
            if some:
                times = ", ".join(f"{onset.time:.3f}" for onset in some[:6])
                more = f" and {len(some) - 6} more" if len(some) > 6 else ""
                yield f"{fate} heard at {times} s{more}"
