"""Which voice an event has: the author's first rule that fits, completed by sensible defaults."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite, log2

from audio.errors import ScoreError
from audio.heard import loudness_db
from audio.instruments import drum_of, program_of
from audio.materials import family_of
from audio.motions import motion_of
from audio.names import folded
from audio.rubs import rub_of
from audio.scales import Scale, parse_scale
from audio.score import Score, ScoreEvent
from audio.words import Sound, Voice, When

# What feet do: a step of the scale for each of them.
_BY_PART = ("footfall", "scuff")

# Middle of the keyboard for a piece of 0.1 m. Real strings and bars climb an octave for half the
# length; two thirds of it keeps a brick and a beetle on one instrument.
_SIZE_PITCH = 67.0
_SEMITONES_PER_HALVING = 8.0
_LOWEST, _HIGHEST = 36, 96


@dataclass(frozen=True, slots=True)
class Note:
    """An event with its voice chosen.

    Attributes:
        event: what happened.
        onset: when it is to be heard [s].
        program: General MIDI program.
        pitch: MIDI pitch; of a drum its key.
        seconds: length of the note [s].
        level: peak level at the listener, gains included [dBFS].
        tuned: whether the author gave the pitch, so that the sound follows it too.
        decay: time in which the sound shall die away [s]; None to leave it to the material.
        send: share of its level that the room is given, 0 to 1.
        drum: whether it is played on the channel of drums.
    """

    event: ScoreEvent
    onset: Fraction
    program: int
    pitch: int
    seconds: float
    level: float
    tuned: bool = False
    decay: float | None = None
    send: float = 0.0
    drum: bool = False


def notes_of(score: Score) -> tuple[Note, ...]:
    """Give every event that is not muted its voice, in an order that hangs on the events alone.

    Raises:
        ScoreError: an event lies outside the score or holds a number that is not finite.
    """
    if score.frames < 1:
        raise ScoreError(f"a score has at least one frame; got {score.frames}")
    if score.rate <= 0:
        raise ScoreError(f"a frame rate is positive; got {score.rate}")
    for event in score.events:
        _check(event, score)
    ranks = _part_ranks(score.events)
    scale = parse_scale(score.sound.scale)
    notes = []
    for event in sorted(score.events, key=_order):
        voice = _first_fitting(score.sound, event)
        if not voice.mute:
            rank = ranks[event.who, _kin(event), event.part]
            notes.append(_note(score, event, voice, scale, rank))
    return tuple(notes)


def _check(event: ScoreEvent, score: Score) -> None:
    name = f"{event.cause} of {event.who}.{event.part} at frame {event.frame}"
    if not 1 <= event.frame <= score.frames:
        raise ScoreError(f"{name} lies outside frames 1 to {score.frames}")
    if not 0 <= score.onset(event) < score.frames / score.rate:
        raise ScoreError(f"{name}: its time, {float(event.time):.6g} s, lies outside the film")
    if not all(isfinite(speed) and speed >= 0 for speed in event.speeds):
        raise ScoreError(f"{name}: its speeds are to be finite and not negative")
    numbers = {
        field: getattr(event, field)
        for field in ("strength", "energy", "size", "distance", "azimuth", "duration")
    }
    for field, value in numbers.items():
        if not isfinite(value):
            raise ScoreError(f"{name}: {field} is {value}")
    if event.size <= 0 or min(event.distance, event.duration, event.energy) < 0:
        raise ScoreError(f"{name}: size is positive; distance, duration and energy not negative")


def _order(event: ScoreEvent) -> tuple[object, ...]:
    return (
        *(event.frame, event.time, event.who, event.part, event.cause, event.other),
        *(event.material, event.surface, event.strength, event.energy, event.size),
        *(event.distance, event.azimuth, event.duration),
    )


def _part_ranks(events: Iterable[ScoreEvent]) -> dict[tuple[str, str, str], int]:
    parts: dict[tuple[str, str], set[str]] = {}
    for event in events:
        parts.setdefault((event.who, _kin(event)), set()).add(event.part)
    return {
        (*of, part): rank
        for of, names in parts.items()
        for rank, part in enumerate(sorted(names, key=_natural))
    }


def _kin(event: ScoreEvent) -> str:
    """Return what causes count their parts together: a knee that squeaks tunes no foot."""
    cause = folded(event.cause)
    return _BY_PART[0] if cause in _BY_PART else cause


def _natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """Return the key that sorts foot_2 before foot_10."""
    pieces = re.findall(r"[0-9]+|[^0-9]+", name)
    return [(int(p), "") if p.isascii() and p.isdigit() else (-1, p) for p in pieces], name


def _first_fitting(sound: Sound, event: ScoreEvent) -> Voice:
    for voice in sound.voices:
        if _fits(voice.when, event):
            return voice
    return Voice()


def _fits(when: When, event: ScoreEvent) -> bool:
    wanted = (
        (when.cause, event.cause),
        (when.who, event.who),
        (when.part, event.part),
        (when.material, event.material),
        (when.surface, event.surface),
    )
    return all(pattern is None or _matches(name, pattern) for pattern, name in wanted)


def _matches(name: str, pattern: str) -> bool:
    pieces = (re.escape(piece) for piece in folded(pattern).split("*"))
    return re.fullmatch(".*".join(pieces), folded(name)) is not None


def _note(score: Score, event: ScoreEvent, voice: Voice, scale: Scale, rank: int) -> Note:
    length = voice.length or event.duration or _natural_length(event)
    default = "by part" if folded(event.cause) in _BY_PART else "by size"
    quiet = rub_of(event.cause) or motion_of(event.cause)
    pitch = voice.pitch if voice.pitch is not None else default
    if voice.drum is not None:
        pitch = drum_of(voice.drum)
    return Note(
        event=event,
        onset=score.onset(event),
        program=program_of(voice.instrument or _instrument(event)),
        pitch=pitch if isinstance(pitch, int) else _scale_pitch(event, scale, pitch, rank),
        seconds=length,
        level=loudness_db(event)
        + (quiet.level if quiet else 0.0)
        + voice.gain_db
        + score.sound.volume_db,
        tuned=voice.pitch is not None,
        decay=voice.length,
        drum=voice.drum is not None,
    )


def _instrument(event: ScoreEvent) -> str:
    motion = motion_of(event.cause)
    own = motion or rub_of(event.cause) or family_of(event.material, "wood")
    return own.instrument


def _natural_length(event: ScoreEvent) -> float:
    """Return how long a note lasts: a larger piece rings longer, a rub is soon over [s]."""
    rub = rub_of(event.cause)
    if rub is not None:
        return rub.seconds
    return min(max(0.25 + 0.5 * event.size, 0.25), 1.5)


def _scale_pitch(event: ScoreEvent, scale: Scale, rule: str, rank: int) -> int:
    by_size = _SIZE_PITCH - _SEMITONES_PER_HALVING * log2(event.size / 0.1)
    degree = scale.degree(min(max(by_size, _LOWEST), _HIGHEST))
    if rule != "by size":
        # Two octaves of steps, then again from the start: a centipede stays in tune and in hearing.
        degree += rank % (2 * len(scale.intervals))
    pitch = scale.pitch(degree)
    while pitch > _HIGHEST:
        pitch -= 12
    while pitch < _LOWEST:
        pitch += 12
    return pitch
