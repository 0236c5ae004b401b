"""Scene music: the music that a score is given, on its beats."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from audio.beat_clock import BeatClock
from audio.harmony import fold_pitch, parse_steps
from audio.music.composition import compose, section_swing
from audio.music.generator import generate
from audio.music.piece import Bar, PieceNote, bars_until
from audio.music.swing import Swing
from audio.parts import DRUMS

if TYPE_CHECKING:
    from audio.score import Score


def music_of(score: Score, clock: BeatClock) -> Iterator[PieceNote]:
    """Yield the notes of the music of a score; some may lie after its end.

    Args:
        score: the score.
        clock: times of its beats.
    """
    music = score.sound.music
    if music is None:
        return
    end = clock.beat(score.frames / score.rate)
    bars = bars_until(clock.meters, music.first_bar, end)
    if not bars:
        return
    scale = parse_steps(score.sound.scale)
    notes: Iterator[PieceNote]
    if music.generate is not None:
        swing = section_swing(music)
        notes = (
            _swung(note, swing, bars)
            for note in generate(music.generate, scale, bars, clock, score.course, score.seed)
        )
    elif music.file is None:
        notes = compose(music, scale, bars)
    else:
        notes = _song_notes(score, bars, end)
    for note in notes:
        is_drum = note.program == DRUMS
        yield note if is_drum else replace(note, pitch=fold_pitch(note.pitch + music.transpose))


def _swung(note: PieceNote, swing: Swing, bars: list[Bar]) -> PieceNote:
    beat, end = swing.beat(note.beat, bars), swing.beat(note.beat + note.beats, bars)
    # Gates leave ends between the steps.
    return replace(note, beat=beat, beats=end - beat if end > beat else note.beats)


def _song_notes(score: Score, bars: list[Bar], end: Fraction) -> Iterator[PieceNote]:
    """Yield the notes of a song, again from its next bar on where it loops."""
    song, music = score.song, score.sound.music
    if song is None or music is None:
        return
    is_in_its_tempo = not score.sound.counts_beats and score.dance is None
    notes = list(song.piece(is_in_its_tempo))
    last = max(note.beat + note.beats for note in notes)
    first = bars[0].beat
    while first < end:
        for note in notes:
            if first + note.beat < end:
                yield replace(note, beat=first + note.beat)
        if not music.loop:
            return
        first = next((bar.beat for bar in bars if bar.beat >= first + last), end)
