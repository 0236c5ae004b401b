"""Score files: what is written beside MIDI and sound, and what is said of them."""

from __future__ import annotations

from typing import Any

from audio.files import put
from audio.midi import MidiReport
from audio.score import Score
from pipeline.production.edit_list import edit_list
from pipeline.production.events import event_lines, event_table
from pipeline.production.labels import label_lines
from pipeline.production.outputs import Outputs
from pipeline.simulation.take import Take


def write_events(outputs: Outputs, take: Take) -> bool:
    """Write the sound events of a take; return whether a file has changed."""
    changed = put(outputs.events, event_lines(take))
    return put(outputs.event_table, event_table(take)) or changed


def write_cues(outputs: Outputs, score: Score) -> bool:
    """Write what editing programs read; return whether a file has changed.

    A film without timecode has no edit list; one of an earlier rate is taken away.
    """
    changed = put(outputs.labels, label_lines(score))
    edits = edit_list(score, outputs.film().name)
    if edits is not None:
        return put(outputs.edit_list, edits) or changed
    gone = outputs.edit_list.exists()
    outputs.edit_list.unlink(missing_ok=True)
    return gone or changed


def facts_of(midi: MidiReport, subframe: bool) -> dict[str, Any]:
    """Return what the manifest says of the MIDI file: above all, which events share a note."""
    return {
        "notes": midi.notes,
        "muted": midi.muted,
        "merged": midi.merged,
        "merged_by_frame": {str(frame): count for frame, count in midi.merged_by_frame.items()},
        "heard_from_a_neighbouring_direction": midi.moved,
        "cut_short": midi.cut_short,
        "tails_cut": midi.tails_cut,
        "without_their_gesture": midi.stiff,
        "subframe": subframe,
    }
