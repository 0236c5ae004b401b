"""Sustain pedal: notes that are let go while it is down sound until it comes up."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction

from audio.music.piece import PieceNote

Span = tuple[Fraction, Fraction]
"""Beats from which, and until which, the pedal is down."""


def pedal_spans(strokes: Iterable[tuple[Fraction, bool]], end: Fraction) -> Iterator[Span]:
    """Yield when a pedal is down.

    Args:
        strokes: beats in the order of time, and whether the pedal goes down; one that is down
            comes up and goes down anew.
        end: beat at which it comes up at last.
    """
    pressed: Fraction | None = None
    for beat, is_down in strokes:
        if pressed is not None and beat > pressed:
            yield pressed, beat
        pressed = beat if is_down else None
    if pressed is not None and end > pressed:
        yield pressed, end


def with_pedal(notes: Iterable[PieceNote], spans: Iterable[Span]) -> list[PieceNote]:
    """Return notes of one part, those that the pedal holds with their longer sound.

    A key that is struck again while it still sounds ends its earlier sound.

    Args:
        notes: in any order.
        spans: of the pedal, in the order of time.
    """
    downs = list(spans)
    held: list[PieceNote] = []
    following: dict[int, Fraction] = {}
    for note in sorted(notes, key=lambda each: each.beat, reverse=True):
        release = note.beat + note.beats
        span = next((each for each in downs if each[0] < release < each[1]), None)
        if span is not None:
            until = min(span[1], following.get(note.pitch, span[1]))
            held.append(replace(note, pedal=span, rings=max(until - note.beat, note.beats)))
        else:
            held.append(note)
        following[note.pitch] = note.beat
    return held[::-1]
