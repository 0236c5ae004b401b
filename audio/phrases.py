"""Phrases: what is played for one event, a note, a chord, or notes one after the other.

Source: Sims 1987, 13.1 (a sound event gives "a note of arbitrary complexity").
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import log10

from audio.chords import parse_chord
from audio.phrase_words import StepWords, Timed
from audio.scales import Scale
from audio.words import Voice

_HALF_A_BEAT = 0.5


@dataclass(frozen=True, slots=True)
class Struck:
    """Pitches that are struck together.

    Attributes:
        after: time from the event [s].
        pitches: of MIDI.
        gain_db: beside the level of the event, of each pitch [dB].
        seconds: how long they last; None where the event decides.
    """

    after: Fraction
    pitches: tuple[int, ...]
    gain_db: float
    seconds: float | None


def answer(
    voice: Voice, pitch: int, scale: Scale, tempo: float, rate: Fraction
) -> Iterator[Struck]:
    """Give what a voice plays for an event, in the order of time; the first with the event.

    Args:
        voice: with its phrase or chord.
        pitch: of the event itself.
        scale: of the degrees.
        tempo: beats a minute.
        rate: frames a second.
    """
    if voice.phrase is None:
        pitches = (pitch,) if voice.chord is None else parse_chord(voice.chord).near(pitch)
        yield _together(Fraction(0), pitches, 0.0, None)
        return
    after = Fraction(0)
    for step in voice.phrase.steps:
        time = _time(step if step.says_when else voice.phrase, tempo, rate)
        if not step.rest:
            length = step.length or voice.length or float(time)
            yield _together(after, _pitches(step, pitch, scale), step.gain_db, length)
        after += time


def _together(
    after: Fraction, pitches: tuple[int, ...], gain_db: float, seconds: float | None
) -> Struck:
    # All of them together carry the power of one note.
    return Struck(after, pitches, gain_db - 10 * log10(len(pitches)), seconds)


def _time(step: Timed, tempo: float, rate: Fraction) -> Fraction:
    """Return the time to the next step [s], decimals as the author wrote them."""
    if step.frames is not None:
        return step.frames / rate
    if step.seconds is not None:
        return Fraction(str(step.seconds))
    beats = _HALF_A_BEAT if step.beats is None else step.beats
    return Fraction(str(beats)) * 60 / Fraction(str(tempo))


def _pitches(step: StepWords, pitch: int, scale: Scale) -> tuple[int, ...]:
    if step.chord is not None:
        return parse_chord(step.chord).near(pitch)
    own = scale.degree(pitch)
    climbed = [pitch + scale.pitch(own + d) - scale.pitch(own) for d in step.degrees]
    return tuple(sorted({heard(each) for each in climbed}))


def heard(pitch: int) -> int:
    """Return the nearest pitch that MIDI has, octaves up or down."""
    while pitch > 127:
        pitch -= 12
    while pitch < 0:
        pitch += 12
    return pitch
