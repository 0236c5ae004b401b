"""Notes: the notes of each event, by the configured voices or by defaults."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from audio.acoustic_materials import family_of
from audio.beat_clock import BeatClock
from audio.cause_voices import FrictionVoice, cause_voice
from audio.config.sound import Sound, Voice
from audio.errors import ScoreError
from audio.general_midi import drum_key, program_number
from audio.harmony import Scale, fold_pitch, parse_steps
from audio.loudness_at_listener import event_level, level_of_velocity, pan_of, reverb_send
from audio.music.piece import Bend
from audio.music.scene_music import music_of
from audio.note_groups import NoteGroup, note_groups
from audio.parts import DRUMS
from audio.pitch_rules import PartRank, Ranks, default_rule, part_ranks, pitch_by_rule, rank_of
from audio.quantisation import TimingShifts, quantise, timing_shifts
from audio.score import Score, ScoreEvent
from audio.tempo_plan import TempoPlan, tempo_plan
from audio.time_grid import nearest_frame_time
from audio.voice_selection import voice_of

MUSIC = "music"
"""Cause of the notes of the music, and the first word of the name of who plays them."""

MAX_MUSIC_NOTES = 200_000
"""Greatest number of notes of the music."""


@dataclass(frozen=True, slots=True)
class _LengthBySize:
    """Default length of a note by the size of its body, because larger bodies ring longer.

    Attributes:
        shortest: of the smallest body [s].
        per_metre: growth with the size [s/m].
        longest: of any body [s].
    """

    shortest: float = 0.25
    per_metre: float = 0.5
    longest: float = 1.5

    def seconds(self, size: float) -> float:
        """Return the length of a body of this size [m]."""
        return min(max(self.shortest + self.per_metre * size, self.shortest), self.longest)


_DEFAULT_LENGTH = _LengthBySize()


@dataclass(frozen=True, slots=True)
class Note:
    """A note of an event.

    Attributes:
        event: its cause; for later notes of a phrase without duration and course.
        onset: time of its sound [s].
        program: General MIDI program.
        pitch: MIDI pitch; of a drum its key.
        seconds: length [s].
        level: peak level at the listener, gains included [dBFS].
        tuned: whether the pitch is configured, so that the sound follows it too.
        decay: configured decay time of the sound [s]; None for that of the material.
        send: share of its level that is sent to the reverb, 0 to 1.
        drum: whether it is played on the drum channel.
        pan: configured pan from left (-1) to right (1); None for that of the event.
        is_first: whether it is the first note of its event; others belong to a chord or phrase.
        bend: of a note of the music, semitones at shares of its length; empty for none.
        pedal: times from which, and until which, the sustain pedal is down that holds it [s].
        rings: time for which it sounds under the pedal [s]; None for its length.
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
    is_first: bool = True
    bend: Bend = ()
    pedal: tuple[Fraction, Fraction] | None = None
    rings: float | None = None

    @property
    def effective_pan(self) -> float:
        """Pan from left (-1) to right (1)."""
        return pan_of(self.event) if self.pan is None else self.pan

    @property
    def is_music(self) -> bool:
        """Whether it belongs to the music, not to an event of the scene."""
        return self.event.cause == MUSIC


@dataclass(frozen=True, slots=True)
class Arrangement:
    """All notes of a score.

    Attributes:
        notes: in an order that depends on the events alone, those of an event together; after
            them those of the music.
        after_the_end: number of phrase notes dropped because they start after the last frame.
        shifts: statistics of the quantisation.
        plan: tempo, meter and bars.
    """

    notes: tuple[Note, ...]
    after_the_end: int
    shifts: TimingShifts
    plan: TempoPlan

    @property
    def event_notes(self) -> tuple[Note, ...]:
        """Notes of events."""
        return tuple(note for note in self.notes if not note.is_music)


def notes_of(score: Score) -> tuple[Note, ...]:
    """Return the notes of a score; raises as `arrange` does."""
    return arrange(score).notes


def first_notes(score: Score) -> tuple[Note, ...]:
    """Return the first note of every event that is not muted; raises as `arrange` does."""
    return tuple(note for note in notes_of(score) if note.is_first)


def arrange(score: Score) -> Arrangement:
    """Return the notes of every event that is not muted.

    Raises:
        ScoreError: an event lies outside the score or holds a number that is not finite, or the
            music has too many notes.
        GridError: the frame rate has no grid.
    """
    score.validate()
    plan = tempo_plan(score)
    ranks = part_ranks(score.events)
    notes: list[Note] = []
    shifts: list[Fraction] = []
    # A crash has hundreds of events on one frame.
    quantised: dict[Fraction, Fraction] = {}
    dropped = 0
    end = score.frames / score.rate
    for event in sorted(score.events, key=_order):
        voice = voice_of(score.sound, event)
        if voice.mute:
            continue
        onset = score.onset(event)
        if score.sound.quantise is not None and voice.quantise:
            if onset not in quantised:
                quantised[onset] = quantise(onset, score.sound.quantise, score, plan.clock)
            shifts.append(quantised[onset] - onset)
            onset = quantised[onset]
        played = list(_event_notes(score, event, voice, ranks, onset, plan.clock))
        within = [note for note in played if note.onset < end]
        dropped += len(played) - len(within)
        notes += within
    notes += _music_notes(score, plan)
    return Arrangement(tuple(notes), dropped, timing_shifts(shifts), plan)


def _music_notes(score: Score, plan: TempoPlan) -> Iterator[Note]:
    """Yield the notes of the music, each on the tick of its beat."""
    grid, end = plan.grid, score.frames / score.rate
    for number, each in enumerate(music_of(score, plan.clock)):
        if number == MAX_MUSIC_NOTES:
            raise ScoreError(
                f"the music has more than {MAX_MUSIC_NOTES} notes; write fewer notes a bar, fewer "
                "parts, or loop: false"
            )
        tick = grid.tick_of_beat(each.beat)
        onset = grid.seconds(max(tick, 0))
        if tick < 0 or onset >= end:
            continue
        event = ScoreEvent(
            frame=grid.frame_at(tick), time=onset, cause=MUSIC, who=f"{MUSIC} {each.part}"
        )
        pedal, rings = None, None
        if each.pedal is not None and each.rings is not None:
            down, up = (grid.seconds(max(grid.tick_of_beat(beat), 0)) for beat in each.pedal)
            pedal = down, up
            rings = float(grid.seconds(grid.tick_of_beat(each.beat + each.rings)) - onset)
        yield Note(
            event=event,
            onset=onset,
            program=max(each.program, 0),
            pitch=each.pitch,
            seconds=float(grid.seconds(grid.tick_of_beat(each.beat + each.beats)) - onset),
            bend=each.bend,
            pedal=pedal,
            rings=rings,
            level=level_of_velocity(each.velocity) + each.gain_db + score.sound.volume_db,
            tuned=True,
            send=each.reverb,
            drum=each.program == DRUMS,
            pan=each.pan,
            is_first=False,
        )


def _order(event: ScoreEvent) -> tuple[object, ...]:
    return (
        *(event.frame, event.time, event.who, event.part, event.cause, event.other),
        *(event.material, event.surface, event.strength, event.energy, event.size),
        *(event.distance, event.azimuth, event.duration),
    )


def _event_notes(
    score: Score,
    event: ScoreEvent,
    voice: Voice,
    ranks: Ranks,
    onset: Fraction,
    clock: BeatClock,
) -> Iterator[Note]:
    sound = score.sound
    scale = parse_steps(voice.scale or sound.scale)
    program = program_number(voice.instrument or _default_instrument(event))
    pitch = _pitch(event, voice, rank_of(ranks, event), scale, program)
    note = Note(
        event=event,
        onset=onset,
        program=program,
        pitch=pitch,
        seconds=voice.length or event.duration or _default_length(event),
        level=_level(event, voice, sound) + voice.gain_db + sound.volume_db,
        tuned=voice.drum is None and any((voice.pitch is not None, voice.chord, voice.phrase)),
        decay=voice.length,
        send=reverb_send(event.distance, sound.reverb if voice.reverb is None else voice.reverb),
        drum=voice.drum is not None,
        pan=voice.pan,
    )
    for group in note_groups(voice, pitch, scale, clock, onset, score.rate):
        yield from _group_notes(note, group, score)


def _group_notes(note: Note, group: NoteGroup, score: Score) -> Iterator[Note]:
    if group.pitches == (note.pitch,) and not (group.delay or group.seconds or group.gain_db):
        yield note
        return
    onset = note.onset + group.delay
    event = note.event
    if group.delay > 0:
        onset = onset if score.subframe else nearest_frame_time(onset, score.rate)
        # A sustained sound happens once; the rest of its phrase are impacts.
        event = replace(event, duration=0.0, speeds=(), course=())
    for index, pitch in enumerate(group.pitches):
        yield replace(
            note,
            event=event,
            onset=onset,
            pitch=pitch,
            seconds=group.seconds or note.seconds,
            level=note.level + group.gain_db,
            is_first=group.delay == 0 and index == 0,
        )


def _pitch(event: ScoreEvent, voice: Voice, rank: PartRank, scale: Scale, program: int) -> int:
    if voice.drum is not None:
        return drum_key(voice.drum)
    pitch = default_rule(event) if voice.pitch is None else voice.pitch
    if not isinstance(pitch, int):
        pitch = pitch_by_rule(pitch, event, rank, scale, program)
    return fold_pitch(pitch + 12 * voice.octave + voice.transpose)


def _level(event: ScoreEvent, voice: Voice, sound: Sound) -> float:
    velocity = voice.velocity or sound.velocity
    level = event_level(velocity, event)
    default = cause_voice(event.cause)
    return level + (default.level if default and velocity.curve == "physical" else 0.0)


def _default_instrument(event: ScoreEvent) -> str:
    return (cause_voice(event.cause) or family_of(event.material)).instrument


def _default_length(event: ScoreEvent) -> float:
    """Return the length of a note [s]: friction has its own, other sounds follow the size."""
    voice = cause_voice(event.cause)
    if isinstance(voice, FrictionVoice):
        return voice.seconds
    return _DEFAULT_LENGTH.seconds(event.size)
