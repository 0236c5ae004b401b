"""Score export: the score for other programs, in a folder of its own beside the film.

The folder is also a project of Reaper: its text names the stems and MIDI files below it.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

from audio.dsp import Gain, Signal
from audio.notation import musicxml
from audio.performer_files import PerformerFile, write_performers
from audio.reaper_project import reaper_project
from audio.score import Score
from audio.sound_files import write_sound_file
from audio.stems import Stem, write_stems
from pipeline.atomic_file import make_folder
from pipeline.production.run.outputs import Outputs
from pipeline.production.sound.export_kind import ExportKind


@dataclass(frozen=True, slots=True)
class Export:
    """Files that were exported.

    Attributes:
        paths: of all of them.
        removed: earlier ones that nobody sounds in any more.
    """

    paths: tuple[Path, ...]
    removed: tuple[Path, ...]


def export_score(
    outputs: Outputs,
    score: Score,
    kinds: Collection[ExportKind],
    gain: Gain,
    curve: Signal | None = None,
    music: float = 1.0,
) -> Export:
    """Write a score for other programs.

    Args:
        outputs: of the scene.
        score: the score.
        kinds: what to write; a Reaper project has stems and performers, too.
        gain: of the master, as a factor, for stems.
        curve: of its limiter alone.
        music: gain of the music beside the events, as a factor.

    Raises:
        AudioError: something cannot be written; earlier files stay.
        OSError: the folder cannot be written to.
    """
    folder = outputs.score_folder
    paths: list[Path] = []
    removed: list[Path] = []
    stems: list[Stem] = []
    performers: list[PerformerFile] = []
    is_project = ExportKind.reaper in kinds
    # First what may be refused, so that nothing is half written.
    sheet = musicxml(score) if ExportKind.musicxml in kinds else None
    if is_project or ExportKind.stems in kinds:
        make_folder(folder / "stems")
        stems = list(write_stems(score, folder / "stems", gain, curve, music))
        removed += _remove_others(folder / "stems", (stem.path for stem in stems))
    if is_project or ExportKind.performers in kinds:
        make_folder(folder / "performers")
        performers = list(write_performers(score, folder / "performers"))
        removed += _remove_others(folder / "performers", (each.path for each in performers))
    paths += [stem.path for stem in stems]
    paths += [each.path for each in performers]
    if sheet is not None:
        make_folder(folder)
        paths.append(folder / f"{outputs.name}.musicxml")
        write_sound_file(paths[-1], sheet)
    if is_project:
        paths.append(folder / f"{outputs.name}.rpp")
        write_sound_file(paths[-1], reaper_project(score, stems, performers, folder))
    return Export(tuple(paths), tuple(removed))


def _remove_others(folder: Path, kept: Iterable[Path]) -> list[Path]:
    """Remove what earlier exports wrote and this one did not."""
    others = sorted({*folder.iterdir()} - {*kept})
    for path in others:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    return others
