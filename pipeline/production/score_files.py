"""Score files: what is written beside MIDI and sound, and what is said of them."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from audio.files import put
from audio.midi import MidiReport
from audio.quantising import Shifts
from audio.score import Score
from pipeline.production.edit_list import edit_list
from pipeline.production.events import event_lines, event_table
from pipeline.production.labels import label_lines
from pipeline.production.run.outputs import Outputs
from pipeline.simulation.take import Take


def write_events(outputs: Outputs, take: Take) -> bool:
    """Write the sound events of a take; return whether a file has changed."""
    changed = put(outputs.events, event_lines(take))
    return put(outputs.event_table, event_table(take)) or changed


def write_cues(outputs: Outputs, score: Score, film: str) -> bool:
    """Write what editing programs read; return whether a file has changed.

    A film without timecode has no edit list; one of an earlier rate is taken away.

    Args:
        outputs: where.
        score: what is heard.
        film: name of the film's file.
    """
    changed = put(outputs.labels, label_lines(score))
    edits = edit_list(score, film)
    if edits is not None:
        return put(outputs.edit_list, edits) or changed
    gone = outputs.edit_list.exists()
    outputs.edit_list.unlink(missing_ok=True)
    return gone or changed


def facts_of(midi: MidiReport, subframe: bool, rate: Fraction) -> dict[str, Any]:
    """Return what the manifest says of the MIDI file: above all, which events share a note."""
    return {
        "notes": midi.notes,
        "muted": midi.muted,
        "added_by_chords_and_phrases": midi.added,
        "left_out_after_the_last_frame": midi.after_the_end,
        "merged": midi.merged,
        "merged_by_frame": {str(frame): count for frame, count in midi.merged_by_frame.items()},
        "heard_from_a_neighbouring_direction": midi.moved,
        "heard_with_another_reverb": midi.reverbs,
        "cut_short": midi.cut_short,
        "tails_cut": midi.tails_cut,
        "without_their_gesture": midi.stiff,
        "subframe": subframe,
        **({"quantised": _told(midi.shifts, rate)} if midi.shifts.asked else {}),
    }


def _told(shifts: Shifts, rate: Fraction) -> dict[str, Any]:
    return {
        "events": shifts.asked,
        "moved": shifts.moved,
        "before_their_cause_is_shown": shifts.earlier,
        "mean_ms": round(float(1000 * shifts.mean), 3),
        "greatest_ms": round(float(1000 * shifts.greatest), 3),
        "mean_frames": round(float(shifts.mean * rate), 3),
        "greatest_frames": round(float(shifts.greatest * rate), 3),
    }


def shifts_line(shifts: Shifts, score: Score) -> str | None:
    """Return what the run says of the quantisation; None where nothing was asked for."""
    words = score.sound.quantise
    if words is None:
        return None
    grid = f"{words.grid} at {score.sound.tempo_bpm:g} beats a minute"
    if not shifts.moved:
        return f"score: all of {shifts.asked} events stand on {grid} by themselves"
    mean, greatest = (1000 * float(by) for by in (shifts.mean, shifts.greatest))
    frames = float(shifts.greatest * score.rate)
    return (
        f"score: {shifts.moved} of {shifts.asked} events moved to {grid}: by {mean:.0f} ms on "
        f"average, {greatest:.0f} ms ({frames:.1f} frames) at most; {shifts.earlier} sound earlier "
        "than they are seen"
    )
