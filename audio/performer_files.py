"""Performer files: the score of each performer as a MIDI file of its own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from audio.midi_file import encode_tracks, play_parts
from audio.names import file_stems
from audio.notes import arrange
from audio.score import Score
from audio.sound_files import write_sound_file


@dataclass(frozen=True, slots=True)
class PerformerFile:
    """A MIDI file of one performer.

    Attributes:
        performer: who sounds.
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
    """

    performer: str
    path: Path
    changed: bool


def write_performers(score: Score, folder: Path) -> Iterator[PerformerFile]:
    """Write the MIDI file of each performer that sounds, and yield each, by name.

    Every file has the tempo, the meter and the markers of the whole score.

    Args:
        score: the score.
        folder: that exists.

    Raises:
        AudioError: as `write_midi` does.
    """
    arrangement = arrange(score)
    performers = sorted({note.event.who for note in arrangement.notes})
    names = file_stems(performers)
    for performer in performers:
        notes = tuple(note for note in arrangement.notes if note.event.who == performer)
        own = replace(arrangement, notes=notes)
        data = encode_tracks(score, own, play_parts(score, own))
        path = folder / f"{names[performer]}.mid"
        yield PerformerFile(performer, path, write_sound_file(path, data))
