"""Notes: what is played for each event, by the author's words and by sensible defaults."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from audio.checks import check
from audio.chords import parse_steps
from audio.fitting import first_fitting
from audio.heard import pan_of
from audio.instruments import drum_of, program_of
from audio.materials import family_of
from audio.motions import motion_of
from audio.names import folded
from audio.phrases import Struck, answer, heard
from audio.pitching import BY_PART, Rank, pitch_by, rank_of, ranks_of
from audio.quantising import Shifts, on_frame, quantised, shifts_of
from audio.rubs import rub_of
from audio.scales import Scale
from audio.score import Score, ScoreEvent
from audio.sends import send_of
from audio.velocities import level_by
from audio.words import Sound, Voice


@dataclass(frozen=True, slots=True)
class Note:
    """A note that is played for an event.

    Attributes:
        event: what happened; for later notes of a phrase without what lasts of it.
        onset: when it is to be heard [s].
        program: General MIDI program.
        pitch: MIDI pitch; of a drum its key.
        seconds: length of the note [s].
        level: peak level at the listener, gains included [dBFS].
        tuned: whether the author gave the pitch, so that the sound follows it too.
        decay: time in which the sound shall die away [s]; None to leave it to the material.
        send: share of its level that the room is given, 0 to 1.
        drum: whether it is played on the channel of drums.
        pan: where the author puts it, left (-1) to right (1); None for where it is.
        opens: whether it is the first note of its event; others belong to its chord or phrase.
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
    pan: float | None = None
    opens: bool = True

    @property
    def side(self) -> float:
        """Where it stands between left (-1) and right (1)."""
        return pan_of(self.event) if self.pan is None else self.pan


@dataclass(frozen=True, slots=True)
class Voiced:
    """All notes of a score.

    Attributes:
        notes: in an order that hangs on the events alone, each event's one after the other.
        after_the_end: notes of phrases that would begin after the last frame; left out.
        shifts: what the quantisation did.
    """

    notes: tuple[Note, ...]
    after_the_end: int
    shifts: Shifts


def notes_of(score: Score) -> tuple[Note, ...]:
    """Return the notes of a score; raises as `voiced` does."""
    return voiced(score).notes


def openings(score: Score) -> tuple[Note, ...]:
    """Return the first note of every event that is not muted; raises as `voiced` does."""
    return tuple(note for note in notes_of(score) if note.opens)


def voiced(score: Score) -> Voiced:
    """Give every event that is not muted its voice.

    Raises:
        ScoreError: an event lies outside the score or holds a number that is not finite.
    """
    check(score)
    ranks = ranks_of(score.events)
    notes: list[Note] = []
    shifts: list[Fraction] = []
    # Of a crash hundreds begin on one frame.
    drawn: dict[Fraction, Fraction] = {}
    left_out = 0
    end = score.frames / score.rate
    for event in sorted(score.events, key=_order):
        voice = first_fitting(score.sound, event)
        if voice.mute:
            continue
        onset = score.onset(event)
        if score.sound.quantise is not None and voice.quantise:
            if onset not in drawn:
                drawn[onset] = quantised(onset, score.sound.quantise, score)
            shifts.append(drawn[onset] - onset)
            onset = drawn[onset]
        played = list(_played(score, event, voice, rank_of(ranks, event), onset))
        within = [note for note in played if note.onset < end]
        left_out += len(played) - len(within)
        notes += within
    return Voiced(tuple(notes), left_out, shifts_of(shifts))


def _order(event: ScoreEvent) -> tuple[object, ...]:
    return (
        *(event.frame, event.time, event.who, event.part, event.cause, event.other),
        *(event.material, event.surface, event.strength, event.energy, event.size),
        *(event.distance, event.azimuth, event.duration),
    )


def _played(
    score: Score, event: ScoreEvent, voice: Voice, rank: Rank, onset: Fraction
) -> Iterator[Note]:
    """Give the notes of one event; all stand on frames unless sounds stand below them."""
    sound = score.sound
    scale = parse_steps(voice.scale or sound.scale)
    program = program_of(voice.instrument or _instrument(event))
    own = _pitch(event, voice, rank, scale, program)
    note = Note(
        event=event,
        onset=onset,
        program=program,
        pitch=own,
        seconds=voice.length or event.duration or _natural_length(event),
        level=_level(event, voice, sound) + voice.gain_db + sound.volume_db,
        tuned=voice.drum is None and any((voice.pitch is not None, voice.chord, voice.phrase)),
        decay=voice.length,
        send=send_of(event.distance, sound.reverb if voice.reverb is None else voice.reverb),
        drum=voice.drum is not None,
        pan=voice.pan,
    )
    for struck in answer(voice, own, scale, sound.tempo_bpm, score.rate):
        yield from _struck(note, struck, score)


def _struck(note: Note, struck: Struck, score: Score) -> Iterator[Note]:
    onset = note.onset + struck.after
    event = note.event
    if struck.after > 0:
        onset = onset if score.subframe else on_frame(onset, score.rate)
        # What lasts does so once; its phrase goes on with blows.
        event = replace(event, duration=0.0, speeds=(), course=())
    for place, pitch in enumerate(struck.pitches):
        yield replace(
            note,
            event=event,
            onset=onset,
            pitch=pitch,
            seconds=struck.seconds or note.seconds,
            level=note.level + struck.gain_db,
            opens=struck.after == 0 and place == 0,
        )


def _pitch(event: ScoreEvent, voice: Voice, rank: Rank, scale: Scale, program: int) -> int:
    if voice.drum is not None:
        return drum_of(voice.drum)
    pitch = voice.pitch
    if pitch is None:
        pitch = "by part" if folded(event.cause) in BY_PART else "by size"
    if not isinstance(pitch, int):
        pitch = pitch_by(pitch, event, rank, scale, program)
    return heard(pitch + 12 * voice.octave + voice.transpose)


def _level(event: ScoreEvent, voice: Voice, sound: Sound) -> float:
    velocity = voice.velocity or sound.velocity
    level = level_by(velocity, event)
    if velocity.curve != "physical":
        return level
    # What only glides or stirs the air gives less of its energy away than a blow.
    quiet = rub_of(event.cause) or motion_of(event.cause)
    return level + (quiet.level if quiet else 0.0)


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
