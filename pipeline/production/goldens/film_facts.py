"""Film facts: container, decoded pictures and sound of a film."""

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
from pipeline.production.goldens.sound_facts import (
    SoundFacts,
    facts_of_sound,
    late_text,
    onset_differences,
    sound_differences,
    sound_from,
)
from pipeline.production.goldens.sound_onsets import (
    RATE,
    Onset,
    measured_onsets,
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
        sound: its levels and how the film carries it; None in goldens that were recorded without.
    """

    container: dict[str, str]
    shown: tuple[tuple[int, str], ...]
    onsets: tuple[Onset, ...]
    sound: SoundFacts | None = None

    def encoded(self) -> str:
        """Return the facts as JSON, a line for each onset and each window of the sound."""
        shown = ", ".join(json.dumps(pair) for pair in self.shown)
        onsets = ",\n".join(f"  {json.dumps(_onset_values(onset))}" for onset in self.onsets)
        container = json.dumps(self.container, indent=1)
        members = f'"container": {container},\n"shown": [{shown}],\n"onsets": [\n{onsets}\n]'
        if self.sound is not None:
            members += f',\n"sound": {_sound_text(self.sound)}'
        return f"{{{members}}}\n"


def _onset_values(onset: Onset) -> list[Any]:
    measured = [list(onset.instants), list(onset.levels)] if onset.instants else []
    return [onset.time, onset.rise, *measured]


def _onset_from(values: list[Any]) -> Onset:
    time, rise, *measured = values
    instants, levels = measured or ((), ())
    return Onset(
        float(time),
        float(rise),
        tuple(None if instant is None else float(instant) for instant in instants),
        tuple(float(level) for level in levels),
    )


def _sound_text(sound: SoundFacts) -> str:
    members = sound.members()
    levels = members.pop("levels")
    rows = ",\n".join(f'  "{k}": {json.dumps(row)}' for k, row in levels.items())
    head = ",\n".join(f"{json.dumps(name)}: {json.dumps(fact)}" for name, fact in members.items())
    return f'{{{head},\n"levels": {{\n{rows}\n}}}}'


def facts_of_film(path: Path, sound: Path) -> FilmFacts:
    """Decode a film whose pictures are slates.

    Args:
        path: of the film.
        sound: WAV file that the film was made with.

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
        if "sound" not in facts:
            return FilmFacts(facts, shown, ())
        written = decoded_sound(sound)
        carried = facts_of_sound(written, decoded_sound(path))
        return FilmFacts(facts, shown, measured_onsets(written), carried)
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


def decoded_sound(path: Path) -> NDArray[np.float32]:
    """Return the sound of a film or a WAV file (channels, N) from time 0 on.

    Raises:
        OSError, ValueError, av.FFmpegError: it cannot be decoded.
    """
    blocks = []
    with av.open(str(path)) as container:
        to_float = av.AudioResampler(format="fltp", rate=RATE)
        for block in container.decode(audio=0):
            for piece in to_float.resample(block):
                first = round(Fraction(piece.pts or 0) * (piece.time_base or 0) * RATE)
                blocks.append((first, piece.to_ndarray()))
    length = max((first + values.shape[1] for first, values in blocks), default=0)
    heard = np.zeros((len(blocks[0][1]) if blocks else 2, length), np.float32)
    for first, values in blocks:
        # Players drop samples before time 0.
        cut = max(-first, 0)
        heard[:, first + cut : first + values.shape[1]] = values[:, cut:]
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
            tuple(_onset_from(values) for values in members["onsets"]),
            sound_from(members["sound"]) if "sound" in members else None,
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
    yield from _heard_differences(golden, new, frame)


def _heard_differences(golden: FilmFacts, new: FilmFacts, frame: float) -> Iterator[str]:
    """Yield the differences of the sound as text: delay, onsets, then levels."""
    late = late_text(golden.onsets, new.onsets, frame)
    if late:
        yield late
    gone, added = unmatched_onsets(golden.onsets, new.onsets, frame / 2)
    for fate, onsets in (("no longer", gone), ("newly", added)):
        if onsets:
            times = ", ".join(f"{onset.time:.3f}" for onset in onsets[:_MAX_LISTED])
            more = f" and {len(onsets) - _MAX_LISTED} more" if len(onsets) > _MAX_LISTED else ""
            yield f"{fate} heard at {times} s{more}"
    if golden.sound is None or new.sound is None:
        return
    starts = onset_differences(golden.onsets, new.onsets, frame)
    yield from sound_differences(golden.sound, new.sound, starts, bool(late))
