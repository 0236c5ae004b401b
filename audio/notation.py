"""Notation: the score as MusicXML, each part a staff, rounded to sixteenths.

music21 writes it, because it knows bars, ties, accidentals and clefs and has been kept since 2006;
it is an optional dependency.
"""

from __future__ import annotations

import re
from collections import defaultdict
from fractions import Fraction
from typing import Any

from audio.errors import NotationError
from audio.key_signature import score_key
from audio.midi_file import PlayedPart, play_parts
from audio.notes import arrange
from audio.parts import DRUMS
from audio.score import Score
from audio.tempo_plan import TempoPlan

# Lengths are in quarter notes, as in music21.
_STEP = Fraction(1, 4)
# What changes from run to run.
_DATES = re.compile(rb"\s*<encoding-date>[^<]*</encoding-date>")


def musicxml(score: Score) -> bytes:
    """Return the score as MusicXML.

    A part has one voice: what sounds together is a chord, and a note ends where the next begins.

    Raises:
        NotationError: music21 is not installed, or cannot write the score.
        ScoreError: an event lies outside the score.
    """
    try:
        import music21
        from music21.musicxml.m21ToXml import GeneralObjectExporter
    except ImportError as error:
        raise NotationError(
            f"MusicXML is written by music21, which is not installed ({error}); "
            "try: pip install music21"
        ) from error
    arrangement = arrange(score)
    sheet = music21.stream.Score()
    sheet.metadata = music21.metadata.Metadata(title=score.title or "score", composer="pronk")
    played = [part for track in play_parts(score, arrangement) for part in track.parts]
    names = [part.part.key.track for part in played]
    for number, part in enumerate(played, start=1):
        key = part.part.key
        name = key.track if names.count(key.track) == 1 else f"{key.track}: {key.instrument}"
        staff = _staff(music21, score, arrangement.plan, part, number)
        staff.id, staff.partName = f"P{number}", name
        sheet.insert(0, staff)
    try:
        data: bytes = GeneralObjectExporter(sheet).parse()
    except music21.exceptions21.Music21Exception as error:
        raise NotationError(f"the score cannot be written as MusicXML: {error}") from error
    return _DATES.sub(b"", data)


def _staff(music21: Any, score: Score, plan: TempoPlan, played: PlayedPart, number: int) -> Any:
    """Return the staff of a part; the first has the tempo marks."""
    grid = plan.grid
    staff = music21.stream.Part()
    key = score_key(score)
    if key is not None:
        tonic, mode = key.rstrip("m").replace("b", "-"), "minor" if key.endswith("m") else "major"
        staff.insert(0, music21.key.Key(tonic.lower() if mode == "minor" else tonic, mode))
    end = grid.tick(score.frames + 1)
    for signature in grid.signatures:
        if signature.tick < end:
            meter = music21.meter.TimeSignature("{}/{}".format(*signature.meter))
            staff.insert(_quarters(signature.tick, grid.ticks_per_beat), meter)
    if number == 1:
        for span, tempo in grid.span_tempos():
            if span.tick < end:
                mark = music21.tempo.MetronomeMark(number=round(float(60_000_000 / tempo), 2))
                staff.insert(_quarters(span.tick, grid.ticks_per_beat), mark)
    program = played.part.key.program
    if program == DRUMS:
        instrument = music21.instrument.Percussion()
        staff.insert(0, music21.clef.PercussionClef())
    else:
        instrument = music21.instrument.instrumentFromMidiProgram(program)
    # music21 would draw them by lot, and its channels are fifteen.
    instrument.partId, instrument.instrumentId = f"P{number}", f"P{number}-I1"
    instrument.midiChannel = played.part.channel
    staff.insert(0, instrument)
    for offset, length, pitches in _voice(played, grid.ticks_per_beat):
        sound = music21.chord.Chord(pitches) if len(pitches) > 1 else music21.note.Note(pitches[0])
        sound.quarterLength = length
        staff.insert(offset, sound)
    return staff.makeRests(fillGaps=True, inPlace=False).makeNotation(inPlace=False)


def _voice(played: PlayedPart, division: int) -> list[tuple[Fraction, Fraction, list[int]]]:
    """Return offset, length and pitches of the notes of a part, one after another."""
    chords: dict[Fraction, set[int]] = defaultdict(set)
    ends: dict[Fraction, Fraction] = defaultdict(Fraction)
    for note in played.notes:
        start = _quarters(note.start, division)
        chords[start].add(note.pitch)
        ends[start] = max(ends[start], _quarters(note.end, division), start + _STEP)
    starts = sorted(chords)
    voice = []
    for start, following in zip(starts, [*starts[1:], None], strict=True):
        end = ends[start] if following is None else min(ends[start], following)
        voice.append((start, end - start, sorted(chords[start])))
    return voice


def _quarters(tick: int, division: int) -> Fraction:
    """Return the sixteenth nearest to a tick, in quarter notes."""
    return round(Fraction(tick, division) / _STEP) * _STEP
