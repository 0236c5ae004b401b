"""Labels: sounds, cuts and instructions as a label track of Audacity."""

from __future__ import annotations

from fractions import Fraction

from audio.conductor import cause_of, told
from audio.score import Score
from audio.voices import openings


def label_lines(score: Score) -> bytes:
    """Return a line for each label: begin and end in seconds, and what it is, with tabs between.

    A sound begins where it is heard; one that lasts is a region.
    """
    labels = [
        (Fraction(marker.frame - 1) / score.rate, 0.0, told(marker)) for marker in score.markers
    ]
    for note in openings(score):
        labels.append((note.onset, note.event.duration, cause_of(note.event)))
    labels.sort(key=lambda label: label[0])
    return "".join(_line(*label) for label in labels).encode("utf-8", "replace")


def _line(start: Fraction, duration: float, text: str) -> str:
    begin = float(start)
    return f"{begin:.6f}\t{begin + duration:.6f}\t{' '.join(text.split())}\n"
