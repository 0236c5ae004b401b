"""Film check: films decoded and compared with their frames and their sound."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.outputs import Outputs
from pipeline.production.sequence.sequence_source import SequenceSource
from render.film_comparison import picture_differences, sound_differences

Source = FilmSource | SequenceSource
"""What a film is made of."""


def film_sources(entries: Mapping[str, Any]) -> dict[str, Source]:
    """Return what each film of a manifest is made of."""
    films = entries.get("films")
    found = {
        name: FilmSource.read(facts) or SequenceSource.read(facts)
        for name, facts in (films or {}).items()
    }
    return {name: source for name, source in found.items() if source is not None}


def is_current(name: str, source: Source, outputs: Outputs, records: FileRecords) -> bool:
    """Return whether a film was made of the frames and the sound that are recorded now."""
    return name in records and records[name].key == source.key(outputs, records)


def film_faults(name: str, source: Source, outputs: Outputs, damaged: Collection[str]) -> list[str]:
    """Return how a film differs from its frames and its sound.

    Args:
        name: of the film's file.
        source: what it is made of.
        outputs: that hold all of it.
        damaged: names of files that nothing is compared with.
    """
    path = outputs.folder / name
    pictures = source.whole_pictures(outputs, damaged)
    found = picture_differences(path, pictures, source.rate, source.codec)
    if outputs.wav.name not in damaged:
        sound = outputs.wav if source.has_sound else None
        found += sound_differences(path, sound, source.sound_from)
    return found
