"""Note groups: the note, chord or phrase that a voice plays for an event.

Source: Sims 1987, 13.1 (a sound event gives "a note of arbitrary complexity").
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import log10

from audio.beat_clock import BeatClock
from audio.config.phrase import PhraseStep, StepTime
from audio.config.sound import Voice
from audio.harmony import Scale, fold_pitch, parse_chord

_DEFAULT_STEP_BEATS = 0.5


@dataclass(frozen=True, slots=True)
class NoteGroup:
    """Notes with the same onset.

    Attributes:
        delay: time from the event [s].
        pitches: MIDI pitches.
        gain_db: of each note, relative to the level of the event [dB].
        seconds: length [s]; None for the length of the event.
    """

    delay: Fraction
    pitches: tuple[int, ...]
    gain_db: float
    seconds: float | None


def note_groups(
    voice: Voice, pitch: int, scale: Scale, clock: BeatClock, onset: Fraction, rate: Fraction
) -> Iterator[NoteGroup]:
    """Yield the notes of a voice for one event in the order of time, the first without delay.

    Args:
        voice: with its phrase or chord.
        pitch: of the event.
        scale: of the degrees.
        clock: of the beats of phrases.
        onset: time of the event [s].
        rate: frames a second.
    """
    if voice.phrase is None:
        pitches = (pitch,) if voice.chord is None else parse_chord(voice.chord).near(pitch)
        yield _note_group(Fraction(0), pitches, 0.0, None)
        return
    delay = Fraction(0)
    for step in voice.phrase.steps:
        time = step if step.has_time else voice.phrase
        seconds = _step_seconds(time, clock, onset + delay, rate)
        if not step.rest:
            length = step.length or voice.length or float(seconds)
            yield _note_group(delay, _step_pitches(step, pitch, scale), step.gain_db, length)
        delay += seconds


def _note_group(
    delay: Fraction, pitches: tuple[int, ...], gain_db: float, seconds: float | None
) -> NoteGroup:
    # All notes together have the power of one.
    return NoteGroup(delay, pitches, gain_db - 10 * log10(len(pitches)), seconds)


def _step_seconds(time: StepTime, clock: BeatClock, start: Fraction, rate: Fraction) -> Fraction:
    """Return the time to the next step [s], exact for decimals as written in the scene."""
    if time.frames is not None:
        return time.frames / rate
    if time.seconds is not None:
        return Fraction(str(time.seconds))
    beats = _DEFAULT_STEP_BEATS if time.beats is None else time.beats
    return clock.time(clock.beat(start) + Fraction(str(beats))) - start


def _step_pitches(step: PhraseStep, pitch: int, scale: Scale) -> tuple[int, ...]:
    if step.chord is not None:
        return parse_chord(step.chord).near(pitch)
    own = scale.degree(pitch)
    moved = [pitch + scale.pitch(own + d) - scale.pitch(own) for d in step.degrees]
    return tuple(sorted({fold_pitch(each) for each in moved}))
