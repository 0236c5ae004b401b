"""Configuration of music: parts, sections of bars, a song from a file, or a generator."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from audio.config import AudioConfig, checked_by, listed_in
from audio.config.quantisation import GridName
from audio.controller_range import BEND_RANGE
from audio.general_midi import drum_key, program_number
from audio.harmony import parse_note
from audio.music.chord_symbols import parse_symbol
from audio.music.notation import MAX_BARS, NotationFault, parse_bars
from audio.names import UnknownName

Instrument = Annotated[str, checked_by(program_number), listed_in("instruments")]
PartName = Annotated[str, Field(min_length=1, max_length=40, pattern=r"^[\w -]+$")]
Octaves = Annotated[int, Field(ge=-8, le=8)]
_LONGEST_TEXT = 8192
_REPEATED = re.compile(r"(.+?)\s+x\s*(\d{1,3})")
_MAX_SLIDES = 8
_DEGREE = re.compile(r"-?\d{1,2}")


SLIDE = ">"
"""Between the pitches of a slide."""


def _check_notes(text: str) -> str:
    for bar in parse_bars(text):
        for step in bar:
            if step.text != "_":
                _check_slide(step.text)
    return text


def _check_slide(text: str) -> None:
    """Check a note, or the notes of a slide from one to the next."""
    names = text.split(SLIDE)
    keys = [_checked_pitch(name) for name in names]
    if len(keys) > _MAX_SLIDES:
        raise NotationFault(f"{text!r}: a slide has at most {_MAX_SLIDES} notes")
    named = [key for key in keys if key is not None]
    if len(named) == len(keys) and max(map(abs, (key - named[0] for key in named))) > BEND_RANGE:
        raise NotationFault(
            f"{text!r}: a slide goes at most {BEND_RANGE} semitones from its first note"
        )


def _checked_pitch(text: str) -> int | None:
    """Return the pitch of a name, None of a degree of a scale that is not known here."""
    if _DEGREE.fullmatch(text):
        return None
    try:
        return parse_note(text)
    except ValueError as error:
        raise ValueError(f"{error}, or a degree of the scale such as 0 or -2") from None


def _check_tones(text: str) -> str:
    for bar in parse_bars(text):
        for step in bar:
            if step.text != "_" and not _DEGREE.fullmatch(step.text):
                raise NotationFault(
                    f"{step.text!r} is no tone of a chord; write 0 for its root, 1 for the next "
                    "tone above, -1 for the next below"
                )
    return text


def _check_strokes(text: str) -> str:
    parse_bars(text, strokes=True)
    return text


def _check_pedal(text: str) -> str:
    for bar in parse_bars(text, strokes=True):
        for step in bar:
            if step.text == "X":
                raise NotationFault("a pedal has no accent; write x (down), o (up) and dots")
    return text


def _check_chords(text: str) -> str:
    for bar in parse_bars(text):
        for step in bar:
            if step.text != "_":
                parse_symbol(step.text)
    return text


BarText = Annotated[str, Field(min_length=1, max_length=_LONGEST_TEXT)]
Notes = Annotated[BarText, checked_by(_check_notes)]
Tones = Annotated[BarText, checked_by(_check_tones)]
Strokes = Annotated[BarText, checked_by(_check_strokes)]
Pedal = Annotated[BarText, checked_by(_check_pedal)]
Chords = Annotated[BarText, checked_by(_check_chords)]
DrumName = Annotated[str, checked_by(drum_key), listed_in("drums")]


class Line(AudioConfig):
    """What a part plays in a section: one of notes, tones, rhythm, arpeggio and drums."""

    notes: Notes | None = Field(
        None,
        description="Bars of notes such as 'C4 [E4 G4] ~ | A4@3 _', or of degrees of the scale, of "
        "which 0 is the root in the octave of C4.",
    )
    tones: Tones | None = Field(
        None, description="Bars of tones of the section's chord: 0 is its root, 1 the next above."
    )
    rhythm: Strokes | None = Field(
        None, description="Bars of strokes, x, X (accent), o (soft) and dots, that play the chord."
    )
    arpeggio: Literal["up", "down", "up down"] | None = Field(
        None, description="Order in which the tones of the chord are played one by one."
    )
    step: GridName = Field("1/8", description="Note value of an arpeggio.")
    octaves: int = Field(1, ge=1, le=4, description="Octaves over which an arpeggio goes.")
    drums: dict[DrumName, Strokes] | None = Field(
        None, description="Bars of strokes for each drum, such as {bass drum: 'x...x...'}."
    )
    pedal: Pedal | None = Field(
        None,
        description="Bars of strokes of the sustain pedal: x goes down, anew where it is down, o "
        "comes up, dots change nothing; it comes up where the section ends.",
    )
    level_db: float = Field(0.0, ge=-60, le=24, description="Gain in this section [dB].")

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        kinds = ("notes", "tones", "rhythm", "arpeggio", "drums")
        given = [kind for kind in kinds if getattr(self, kind) is not None]
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise ValueError(f"give one of {', '.join(kinds)}; got {got}")
        if self.arpeggio is None and (more := {"step", "octaves"} & self.model_fields_set):
            raise ValueError(f"{' and '.join(sorted(more))} belong to an arpeggio; remove them")
        if self.drums is not None and self.pedal is not None:
            raise ValueError("drums have no pedal; remove pedal")
        return self

    @property
    def needs_chords(self) -> bool:
        """Whether it plays the chords of its section."""
        return any(kind is not None for kind in (self.tones, self.rhythm, self.arpeggio))

    @property
    def bars(self) -> int:
        """Number of bars that are written."""
        texts = [text for text in (self.notes, self.tones) if text is not None]
        strokes = [self.rhythm] if self.rhythm is not None else list((self.drums or {}).values())
        strokes += [] if self.pedal is None else [self.pedal]
        counts = [len(parse_bars(text)) for text in texts]
        return max([*counts, *(len(parse_bars(text, strokes=True)) for text in strokes)], default=1)


LineOrNotes = Annotated[
    Line,
    BeforeValidator(
        lambda value: {"notes": value} if isinstance(value, str) else value,
        json_schema_input_type=str | Line,
    ),
]


class MusicPart(AudioConfig):
    """An instrument of the music."""

    instrument: Instrument | None = Field(
        None, description="Name of the General MIDI instrument; none for the drum kit."
    )
    octave: Octaves = Field(0, description="Octaves higher, or lower.")
    velocity: int = Field(84, ge=1, le=127, description="Velocity of notes without an accent.")
    gate: float = Field(0.95, gt=0, le=1, description="Share of a step for which a note sounds.")
    level_db: float = Field(0.0, ge=-60, le=24, description="Gain [dB].")
    pan: float = Field(0.0, ge=-1, le=1, description="From left (-1) to right (1).")
    reverb: float = Field(0.25, ge=0, le=1, description="Share that is reverberated; 0 is dry.")


SwingShare = Annotated[float, Field(ge=0.5, le=0.75)]


class MusicSection(AudioConfig):
    """Some bars of the music."""

    bars: int | None = Field(
        None, ge=1, le=MAX_BARS, description="Number of bars; those of its longest text by default."
    )
    chords: Chords | None = Field(
        None,
        description="Bars of chords such as 'Am7 | F G', or of numerals of the scale, 'i | VI'.",
    )
    play: dict[PartName, LineOrNotes] = Field(
        description="What each part plays: bars of notes, or a mapping. Shorter ones repeat."
    )

    swing: SwingShare | None = Field(
        None, description="Share of the first of two steps in this section; that of the music."
    )

    @model_validator(mode="after")
    def _check_chords(self) -> Self:
        for name, line in self.play.items():
            if line.needs_chords and self.chords is None:
                raise ValueError(f"'{name}' plays the chords of its section; give chords")
        bars = [] if self.chords is None else parse_bars(self.chords)[: self.length]
        if self.chords is not None and all(step.text == "_" for bar in bars for step in bar):
            raise ValueError("no bar of the section has a chord; write at least one")
        return self

    @property
    def length(self) -> int:
        """Number of bars."""
        if self.bars is not None:
            return self.bars
        chords = 1 if self.chords is None else len(parse_bars(self.chords))
        return max([chords, *(line.bars for line in self.play.values())])


class MusicGenerator(AudioConfig):
    """Music that follows the scene: harmony its tension, notes its motion and events."""

    seed: int = Field(0, ge=0, le=2**31, description="Another piece of the same kind.")
    instruments: dict[Literal["pad", "bass", "arpeggio", "melody"], Instrument] = Field(
        {}, description="Instruments instead of the usual ones, by their role."
    )
    leave_out: tuple[Literal["pad", "bass", "arpeggio", "melody", "drums"], ...] = Field(
        (), description="Roles that are not played."
    )
    energy: float = Field(0.5, ge=0, le=1, description="How many notes, all in all.")


class Music(AudioConfig):
    """The music of a scene: sections of bars, a song from a MIDI file, or a generator."""

    parts: dict[PartName, MusicPart] = Field({}, description="Instruments by name.")
    sections: dict[PartName, MusicSection] = Field({}, description="Sections by name.")
    form: tuple[Annotated[str, Field(min_length=1, max_length=80)], ...] = Field(
        (),
        max_length=500,
        description="Sections in their order, 'verse x2' for twice; all of them once by default.",
    )
    loop: bool = Field(True, description="Whether it starts anew until the film ends.")
    file: str | None = Field(
        None, min_length=1, description="A MIDI file (.mid) beside the scene that is played."
    )
    generate: MusicGenerator | None = Field(
        None, description="A generator that follows the scene; {} for the usual one."
    )
    first_bar: int = Field(1, ge=1, le=10_000, description="Bar of the score at which it begins.")
    transpose: int = Field(0, ge=-48, le=48, description="Semitones higher, or lower.")
    swing: SwingShare = Field(
        0.5, description="Share of the first of two steps: 0.5 is even, 0.667 a triplet's swing."
    )
    swing_step: GridName = Field("1/8", description="Note value of the steps that swing.")
    level_db: float = Field(
        0.0,
        ge=-60,
        le=24,
        description="How much louder the music is than the sounds of the scene [dB].",
    )

    @field_validator("parts", "sections")
    @classmethod
    def _check_number(cls, value: dict[str, Any]) -> dict[str, Any]:
        if len(value) > MAX_PARTS:
            raise ValueError(f"{len(value)} of them; at most {MAX_PARTS}")
        return value

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        sources = {
            "sections": bool(self.sections),
            "file": self.file is not None,
            "generate": self.generate is not None,
        }
        given = [key for key, is_given in sources.items() if is_given]
        if len(given) != 1:
            raise ValueError(
                f"give one of sections, file and generate; got {' and '.join(given) or 'none'}"
            )
        if not self.sections and (self.parts or self.form):
            raise ValueError("parts and form belong to sections; give sections, or leave them out")
        if self.file is not None and (swung := {"swing", "swing_step"} & self.model_fields_set):
            raise ValueError(f"a song swings as it is played; remove {' and '.join(sorted(swung))}")
        if self.generate is not None and "loop" in self.model_fields_set:
            raise ValueError("generated music never repeats; remove loop")
        for section in self.sections.values():
            for name, line in section.play.items():
                if name not in self.parts:
                    raise UnknownName("part of the music", name, self.parts)
                is_kit = self.parts[name].instrument is None
                if is_kit and self.parts[name].octave:
                    raise ValueError(f"part '{name}' is a drum kit, which has no octave")
                if is_kit != (line.drums is not None):
                    wanted = "drums, for it has no instrument" if is_kit else "no drums"
                    raise ValueError(f"part '{name}' plays {wanted}")
        self.sequence()
        return self

    def sequence(self) -> tuple[str, ...]:
        """Return the names of the sections in the order in which they are played.

        Raises:
            UnknownName: the form has a section that is not there.
        """
        names: list[str] = []
        for entry in self.form:
            match = _REPEATED.fullmatch(entry.strip())
            name, times = (match[1], int(match[2])) if match else (entry.strip(), 1)
            if name not in self.sections:
                raise UnknownName("section", name, self.sections)
            if times == 0:
                raise ValueError(f"'{entry}' plays nothing; leave it out")
            names += [name] * times
        return tuple(names) or tuple(self.sections)


MAX_PARTS = 64
"""Greatest number of parts, and of sections."""
