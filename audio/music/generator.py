"""Generator: music that follows a scene, bar by bar.

Tension chooses harmony and register: at rest the tonic and its relatives, under tension chords
that lead away, sevenths, and a higher melody. Motion chooses how many notes are played, as
Euclidean rhythms of more onsets. Everything else is drawn by lot from the seed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import numpy as np

from audio.beat_clock import BeatClock
from audio.config.music import MusicGenerator
from audio.general_midi import drum_key, program_number
from audio.harmony import MODES, Scale, fold_pitch
from audio.music.notation import euclidean_rhythm
from audio.music.piece import Bar, PieceNote
from audio.music.scene_course import SceneCourse
from audio.parts import DRUMS
from audio.seeded import seeded

_INSTRUMENTS: dict[str, str] = {
    "pad": "string ensemble 1",
    "bass": "acoustic bass",
    "arpeggio": "acoustic grand piano",
    "melody": "clarinet",
}
_PANS = {"pad": 0.0, "bass": 0.0, "arpeggio": -0.3, "melody": 0.25, "drums": 0.0}
_VELOCITIES = {"pad": 58, "bass": 76, "arpeggio": 62, "melody": 78, "drums": 70}

# How tense each chord of a scale of seven steps is, by the step of its root; those of major scales
# first. The leading tone's and the dominant's pull most.
_TENSION = {
    "major": (0.0, 0.45, 0.3, 0.35, 0.7, 0.15, 1.0),
    "minor": (0.0, 0.9, 0.2, 0.45, 0.75, 0.25, 0.6),
}
_REPETITION = 0.45
# Spread of a chord's tension around the one that is asked for: chords are drawn at random.
_WIDTH = 0.22
_SLOTS = 16
_HIGHEST_VELOCITY = 120
_SEVENTH_FROM, _DRUMS_FROM, _SNARE_FROM = 0.55, 0.3, 0.5
_CADENCE = 8


@dataclass(frozen=True, slots=True)
class _Moment:
    """What a bar is made of.

    Attributes:
        bar: its beats.
        degrees: of its chord, as degrees of the scale.
        tension: 0 to 1.
        motion: 0 to 1, with the energy that is configured.
    """

    bar: Bar
    degrees: tuple[int, ...]
    tension: float
    motion: float


def seven_steps(scale: Scale) -> Scale:
    """Return a scale of seven steps with the root of another, minor where its third is."""
    if len(scale.intervals) == 7:
        return scale
    kind = "minor" if 3 in scale.intervals and 4 not in scale.intervals else "major"
    return Scale(scale.root, MODES[kind])


def generate(
    config: MusicGenerator,
    scale: Scale,
    bars: Sequence[Bar],
    clock: BeatClock,
    course: SceneCourse,
    seed: int,
) -> Iterator[PieceNote]:
    """Yield the notes of bars.

    Args:
        config: of the generator.
        scale: of the scene.
        bars: of the score.
        clock: times of beats.
        course: tension and motion of the scene.
        seed: of the scene.
    """
    scale = seven_steps(scale)
    root = 0
    melody = _Melody(scale)
    for number, bar in enumerate(bars):
        rng = partial(seeded, seed, config.seed, number)
        start, end = (float(clock.time(beat)) for beat in (bar.beat, bar.beat + bar.beats))
        tension, motion = course.between(start, end)
        motion = min(motion * 2 * config.energy, 1.0)
        root = _next_root(root, scale, tension, number, rng("chord"))
        tones = (0, 2, 4, 6) if tension > _SEVENTH_FROM else (0, 2, 4)
        moment = _Moment(bar, tuple(root + tone for tone in tones), tension, motion)
        roles = {
            "pad": _pad(moment, scale),
            "bass": _bass(moment, scale),
            "arpeggio": _arpeggio(moment, scale, rng("arpeggio")),
            "melody": melody.bar(moment, rng("melody")),
            "drums": _drums(moment, rng("drums")),
        }
        for role, notes in roles.items():
            if role in config.leave_out:
                continue
            program = DRUMS
            if role != "drums":
                names = {**_INSTRUMENTS, **{str(k): name for k, name in config.instruments.items()}}
                program = program_number(names[role])
            for beat, beats, pitch, loudness in notes:
                velocity = round(_VELOCITIES[role] * loudness * (0.85 + 0.3 * tension))
                yield PieceNote(
                    *(bar.beat + beat, beats, role, program, pitch),
                    velocity=min(max(velocity, 1), _HIGHEST_VELOCITY),
                    pan=_PANS[role],
                )


_Sound = tuple[Fraction, Fraction, int, float]
"""Beat within the bar, length, pitch, and loudness relative to the usual."""


def _next_root(
    root: int, scale: Scale, tension: float, number: int, rng: np.random.Generator
) -> int:
    """Return the step of the next chord: drawn by lot among those about as tense as the scene."""
    if number % _CADENCE == 0:
        return 0
    levels = np.array(_TENSION["minor" if 3 in scale.intervals else "major"])
    weight = np.exp(-0.5 * ((levels - tension) / _WIDTH) ** 2) + 0.03
    weight[root] *= _REPETITION
    # Falling fifths and steps lead on.
    weight[(root + 3) % 7] *= 1.6
    # Drawn from sums of whole numbers, which are the same on every processor.
    bounds = np.cumsum(np.rint(1000 * weight).astype(np.int64))
    return int(np.searchsorted(bounds, rng.integers(bounds[-1]), side="right"))


def _pitch(scale: Scale, degree: int, low: int) -> int:
    """Return the pitch of a degree within the octave above a pitch."""
    pitch = scale.pitch(degree)
    return low + (pitch - low) % 12


def _onsets(bar: Bar, count: int, turn: int = 0) -> Iterator[tuple[Fraction, Fraction]]:
    """Yield beat and length of so many onsets, spread evenly over the sixteenths of a bar."""
    slots = max(int(bar.beats * 4), 1)
    rhythm = euclidean_rhythm(min(max(count, 1), slots), slots, turn)
    places = [slot for slot, sounds in enumerate(rhythm) if sounds]
    for place, following in zip(places, [*places[1:], slots], strict=True):
        yield Fraction(place, 4), Fraction(following - place, 4)


def _pad(moment: _Moment, scale: Scale) -> Iterator[_Sound]:
    low = 53 + round(5 * moment.tension)
    for pitch in sorted({_pitch(scale, degree, low) for degree in moment.degrees}):
        yield Fraction(0), moment.bar.beats, pitch, 0.8 + 0.3 * moment.tension


def _bass(moment: _Moment, scale: Scale) -> Iterator[_Sound]:
    count = 1 + round(4 * moment.motion)
    for number, (beat, beats) in enumerate(_onsets(moment.bar, count)):
        degree = moment.degrees[2] if number % 4 == 2 else moment.degrees[0]
        yield beat, beats * Fraction(9, 10), _pitch(scale, degree, 33), 1.0 if beat else 1.15


def _arpeggio(moment: _Moment, scale: Scale, rng: np.random.Generator) -> Iterator[_Sound]:
    count = round(2 + 12 * moment.motion)
    start = int(rng.integers(len(moment.degrees)))
    for number, (beat, beats) in enumerate(_onsets(moment.bar, count)):
        step = (start + number) % (2 * len(moment.degrees))
        octave, tone = divmod(step, len(moment.degrees))
        pitch = _pitch(scale, moment.degrees[tone], 60) + 12 * octave
        yield beat, beats, pitch, 0.85 + 0.25 * (beat.denominator == 1)


def _drums(moment: _Moment, rng: np.random.Generator) -> Iterator[_Sound]:
    if moment.motion < _DRUMS_FROM:
        return
    stroke = Fraction(1, 4)
    for beat, _ in _onsets(moment.bar, 2 + round(2 * moment.motion)):
        yield beat, stroke, drum_key("bass drum"), 1.1
    for number, (beat, _) in enumerate(_onsets(moment.bar, 4 + round(8 * moment.motion))):
        yield beat, stroke, drum_key("closed hi-hat"), 0.6 + 0.25 * (number % 2 == 0)
    if moment.motion > _SNARE_FROM:
        for back in range(1, int(moment.bar.beats), 2):
            yield Fraction(back), stroke, drum_key("side stick"), 0.9 + 0.2 * rng.random()


class _Melody:
    """A line that moves by steps, and comes to rest on tones of the chord."""

    def __init__(self, scale: Scale) -> None:
        self._scale = scale
        self._degree = scale.degree(72)

    def bar(self, moment: _Moment, rng: np.random.Generator) -> Iterator[_Sound]:
        """Yield the melody of a bar; in a calm one it may pause."""
        if rng.random() > 0.55 + 0.4 * moment.motion:
            return
        count = 1 + round(rng.integers(1, 4) + 4 * moment.motion)
        goal = self._scale.degree(67 + round(12 * moment.tension))
        for beat, beats in _onsets(moment.bar, count, int(rng.integers(_SLOTS))):
            if beat.denominator <= 2:
                near = [d + 7 * octave for d in moment.degrees for octave in range(12)]
                wish = self._degree + (1 if goal > self._degree else -1)
                self._degree = min(near, key=lambda degree: (abs(degree - wish), degree))
            else:
                self._degree += int(rng.choice((-1, 1)))
            pitch = fold_pitch(self._scale.pitch(self._degree), 60, 91)
            yield beat, beats * Fraction(9, 10), pitch, 0.9 + 0.2 * (not beat)
