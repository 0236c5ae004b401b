"""Composition: sections of bars -> notes, in the order of the form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from audio.config.music import SLIDE, Line, Music, MusicPart, MusicSection
from audio.config.quantisation import beats_of_grid
from audio.controller_range import BEND_RANGE
from audio.general_midi import drum_key, program_number
from audio.harmony import MIDDLE_C, Chord, Scale, fold_pitch, parse_note
from audio.music.chord_symbols import Numeral, parse_symbol
from audio.music.notation import HOLD, Step, parse_bars
from audio.music.piece import Bar, Bend, PieceNote
from audio.music.sustain_pedal import pedal_spans, with_pedal
from audio.music.swing import Swing
from audio.parts import DRUMS

_ACCENT, _SOFT = 22, 0.55
_HALF_OCTAVE = 6


@dataclass(frozen=True, slots=True)
class Stroke:
    """A sound of a line before it has an instrument.

    Attributes:
        beat: of its onset.
        beats: its length.
        text: what sounds.
        accent: whether it is accented.
    """

    beat: Fraction
    beats: Fraction
    text: str
    accent: bool = False


def compose(music: Music, scale: Scale, bars: Sequence[Bar]) -> Iterator[PieceNote]:
    """Yield the notes of sections, each in the bars that follow those of the one before.

    Args:
        music: with sections.
        scale: of degrees and numerals.
        bars: of the score, from the one at which the music begins.

    Raises:
        ValueError: the scale has no chords for a numeral.
    """
    at = 0
    while at < len(bars):
        for name in music.sequence():
            section = music.sections[name]
            own = bars[at : at + section.length]
            at += section.length
            swing = section_swing(music, section)
            for part, line in section.play.items():
                notes = _line_notes(part, music.parts[part], line, section, scale, own, swing)
                yield from _held_notes(notes, line, own, swing)
        if not music.loop:
            return


def check_chords(music: Music, scale: Scale) -> None:
    """Refuse numerals for which a scale has no chords.

    Raises:
        ValueError: it has none; the message names the section.
    """
    for name, section in music.sections.items():
        if section.chords is not None:
            try:
                list(_chords(section, scale, [Bar(Fraction(0), Fraction(4))] * section.length))
            except ValueError as error:
                raise ValueError(f"music.sections.{name}.chords: {error}") from None


def section_swing(music: Music, section: MusicSection | None = None) -> Swing:
    """Return the swing of a section; without one that of the music."""
    own = None if section is None else section.swing
    share = music.swing if own is None else own
    return Swing(Fraction(str(share)), beats_of_grid(music.swing_step))


def _held_notes(
    notes: Iterator[PieceNote], line: Line, bars: Sequence[Bar], swing: Swing
) -> Iterator[PieceNote]:
    """Yield the notes of a line as its pedal holds them."""
    if line.pedal is None or not bars:
        yield from notes
        return
    strokes = [
        (swing.beat(stroke.beat, bars), stroke.text == "x")
        for stroke in _strokes(line.pedal, bars, strokes=True)
    ]
    yield from with_pedal(notes, pedal_spans(strokes, bars[-1].beat + bars[-1].beats))


def _line_notes(
    name: str,
    part: MusicPart,
    line: Line,
    section: MusicSection,
    scale: Scale,
    bars: Sequence[Bar],
    swing: Swing,
) -> Iterator[PieceNote]:
    middle = MIDDLE_C + 12 * part.octave
    if line.drums is not None:
        for drum, text in line.drums.items():
            for stroke in _strokes(text, bars, strokes=True):
                yield _note(name, part, line, _swung(stroke, swing, bars), drum_key(drum), DRUMS)
        return
    program = program_number(part.instrument or "")
    for stroke, pitches, bend in _melodic_strokes(line, section, scale, bars, middle):
        for pitch in pitches:
            note = _note(name, part, line, _swung(stroke, swing, bars), pitch, program)
            yield replace(note, bend=bend) if bend else note


def _swung(stroke: Stroke, swing: Swing, bars: Sequence[Bar]) -> Stroke:
    beat = swing.beat(stroke.beat, bars)
    end = swing.beat(stroke.beat + stroke.beats, bars)
    return replace(stroke, beat=beat, beats=end - beat)


def _melodic_strokes(
    line: Line, section: MusicSection, scale: Scale, bars: Sequence[Bar], middle: int
) -> Iterator[tuple[Stroke, Sequence[int], Bend]]:
    """Yield the strokes of a line with their pitches and slides."""
    if line.notes is not None:
        for stroke in _strokes(line.notes, bars):
            first, *others = (_pitch(text, scale, middle) for text in stroke.text.split(SLIDE))
            yield stroke, (first,), slide([pitch - first for pitch in others])
        return
    chords = list(_chords(section, scale, bars))
    if line.rhythm is not None:
        for stroke in _strokes(line.rhythm, bars, strokes=True):
            yield stroke, _close_voicing(_chord_at(chords, stroke.beat), middle), ()
        return
    tones = (
        _arpeggio(line, chords, bars)
        if line.tones is None
        else ((stroke, int(stroke.text)) for stroke in _strokes(line.tones, bars))
    )
    for stroke, tone in tones:
        yield stroke, (_tone(_chord_at(chords, stroke.beat).near(middle), tone),), ()


def slide(intervals: Sequence[int]) -> Bend:
    """Return the bend of a note that slides to others.

    All pitches share its length evenly; it slides in the halves of their shares that meet.

    Args:
        intervals: of the pitches above the first, in the order of time [semitones].
    """
    if not intervals:
        return ()
    pitches, share = [0, *intervals], 1 / (len(intervals) + 1)
    points = []
    for k, (earlier, later) in enumerate(pairwise(pitches), start=1):
        points += [((k - 0.25) * share, float(earlier)), ((k + 0.25) * share, float(later))]
    return tuple((at, min(max(value, -BEND_RANGE), BEND_RANGE)) for at, value in points)


def _note(
    name: str, part: MusicPart, line: Line, stroke: Stroke, pitch: int, program: int
) -> PieceNote:
    soft = stroke.text == "o" and line.notes is None
    accent = stroke.accent or (stroke.text == "X" and line.notes is None)
    velocity = round(part.velocity * _SOFT) if soft else part.velocity + _ACCENT * accent
    return PieceNote(
        beat=stroke.beat,
        beats=stroke.beats * Fraction(str(part.gate)),
        part=name,
        program=program,
        pitch=fold_pitch(pitch),
        velocity=min(max(velocity, 1), 127),
        gain_db=part.level_db + line.level_db,
        pan=part.pan,
        reverb=part.reverb,
    )


def _strokes(text: str, bars: Sequence[Bar], strokes: bool = False) -> list[Stroke]:
    """Return the strokes of a text that is repeated until the bars end, holds added to them."""
    written = parse_bars(text, strokes)
    found: list[Stroke] = []
    for number, bar in enumerate(bars):
        for step in written[number % len(written)]:
            _add_stroke(found, step, bar)
    return found


def _add_stroke(found: list[Stroke], step: Step, bar: Bar) -> None:
    beat, beats = bar.beat + step.start * bar.beats, step.length * bar.beats
    if step.text != HOLD:
        found.append(Stroke(beat, beats, step.text, step.accent))
        return
    for i in range(len(found) - 1, max(len(found) - 12, -1), -1):
        held = found[i]
        if held.beat + held.beats == beat:
            found[i] = Stroke(held.beat, held.beats + beats, held.text, held.accent)


def _chords(
    section: MusicSection, scale: Scale, bars: Sequence[Bar]
) -> Iterator[tuple[Fraction, Chord]]:
    """Yield the chords of a section, each with its first beat."""
    if section.chords is None:
        return
    for stroke in _strokes(section.chords, bars):
        symbol = parse_symbol(stroke.text)
        yield stroke.beat, symbol.chord(scale) if isinstance(symbol, Numeral) else symbol


def _chord_at(chords: Sequence[tuple[Fraction, Chord]], beat: Fraction) -> Chord:
    """Return the chord at a beat: the last that has begun, before the first the first."""
    return next((chord for start, chord in reversed(chords) if start <= beat), chords[0][1])


def _pitch(text: str, scale: Scale, middle: int) -> int:
    if text.lstrip("-").isdigit():
        return scale.pitch(int(text)) + middle
    return parse_note(text) + middle - MIDDLE_C


def _tone(tones: Sequence[int], number: int) -> int:
    """Return a tone of a chord, counted upward from its root and on into other octaves."""
    octave, tone = divmod(number, len(tones))
    return tones[tone] + 12 * octave


def _close_voicing(chord: Chord, middle: int) -> list[int]:
    """Return the tones of a chord within an octave about a pitch, so that few of them leap."""
    low = middle - _HALF_OCTAVE
    return sorted({low + (chord.root + interval - low) % 12 for interval in chord.intervals})


def _arpeggio(
    line: Line, chords: Sequence[tuple[Fraction, Chord]], bars: Sequence[Bar]
) -> Iterator[tuple[Stroke, int]]:
    step = beats_of_grid(line.step)
    count = 0
    chord = None
    for bar in bars:
        beat = bar.beat
        while beat < bar.beat + bar.beats:
            now = _chord_at(chords, beat)
            count = 0 if now is not chord else count + 1
            chord = now
            order = arpeggio_order(line.arpeggio or "up", len(now.intervals) * line.octaves)
            length = min(step, bar.beat + bar.beats - beat)
            yield Stroke(beat, length, "", accent=count == 0), order[count % len(order)]
            beat += step


def arpeggio_order(kind: str, tones: int) -> list[int]:
    """Return the order in which the tones of an arpeggio follow each other."""
    up = list(range(tones))
    return {"up": up, "down": up[::-1], "up down": up + up[-2:0:-1]}[kind]
