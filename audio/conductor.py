"""The conductor's track: what holds for all, where the film is cut, and why each note is there."""

from __future__ import annotations

from fractions import Fraction

import mido

from audio.grid import Grid
from audio.score import Marker, Score, ScoreEvent
from audio.tracks import Timed, clean, name
from audio.voices import Note

# Rates that an SMPTE offset has a code for, as mido names them. The code of 30000/1001 counts
# with dropped numbers, which at offset zero differs from counting them all in nothing.
_SMPTE_CODES = {
    Fraction(24): 24,
    Fraction(25): 25,
    Fraction(30000, 1001): 29.97,
    Fraction(30): 30,
}


def conductor(score: Score, grid: Grid, notes: tuple[Note, ...]) -> list[Timed]:
    """Return title, grid, markers at cuts and instructions, and a cue point for each event."""
    markers = [
        (grid.tick(marker.frame), mido.MetaMessage("marker", text=clean(told(marker))))
        for marker in score.markers
    ]
    cues = [
        (
            grid.tick_at(note.onset),
            mido.MetaMessage("cue_marker", text=clean(cause_of(note.event))),
        )
        for note in notes
        if note.opens
    ]
    return [*_head(score, grid), *markers, *cues]


def _head(score: Score, grid: Grid) -> list[Timed]:
    head = [
        mido.MetaMessage("text", text=clean(f"title: {score.title}")),
        mido.MetaMessage("text", text=f"frames: {score.frames} at {score.rate} a second"),
    ]
    if score.rate in _SMPTE_CODES:
        # The film starts at 00:00:00:00; mido would start it at another hour.
        code = _SMPTE_CODES[score.rate]
        head.append(mido.MetaMessage("smpte_offset", frame_rate=code, hours=0))
    head.append(mido.MetaMessage("set_tempo", tempo=grid.tempo))
    head.append(mido.MetaMessage("time_signature", numerator=4, denominator=4))
    return [name(score.title or "score"), *((0, message) for message in head)]


def told(marker: Marker) -> str:
    """Return a marker in words, such as "cut: side of bug"."""
    return f"{marker.kind}: {marker.text}"


def cause_of(event: ScoreEvent) -> str:
    """Return the cause of a sound in words, such as "footfall: bug.l1 > terrain"."""
    what = f"{event.cause}: {event.who}" + (f".{event.part}" if event.part else "")
    return what + (f" > {event.other}" if event.other else "")
