"""Verification: every output of a scene against its record, its key and what it is made of."""

from __future__ import annotations

import contextlib
import glob
import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from audio.layouts import LAYOUTS
from pipeline.atomic_file import write_if_changed
from pipeline.errors import UsageError
from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.film_source import FilmSource
from pipeline.production.run.manifest import Manifest
from pipeline.production.run.outputs import Outputs, locked
from pipeline.production.run.progress import Reporter, Stage, stage
from pipeline.production.sequence.sequence_source import SequenceSource
from pipeline.production.verification.fault import MISSING, NOT_AS_WRITTEN, Fault, OutputsDamaged
from pipeline.production.verification.file_check import fault_of, is_frame
from pipeline.production.verification.film_check import film_faults, film_sources, is_current
from pipeline.spec import find_scene
from render.film_codecs import CONTAINERS


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a verification of outputs without a fault has seen.

    Attributes:
        files: number of files.
        films: names of the films that were compared with their frames.
        remarks: on what could not be judged.
    """

    files: int
    films: tuple[str, ...]
    remarks: tuple[str, ...]

    def __str__(self) -> str:
        films = f", {', '.join(self.films)} as its frames and its sound" if self.films else ""
        return f"{self.files} files as they were written{films}"


def outputs_of(target: str, out: Path) -> Outputs:
    """Return the outputs that a command names.

    Args:
        target: folder of the outputs of a scene, or file or name of a scene.
        out: folder that holds the scenes' folders.

    Raises:
        UsageError: there are none.
    """
    folder = Path(target)
    if not os.path.isdir(folder):  # false for a name that is too long
        name = find_scene(target).stem
        found = Outputs(out / name, name)
        if not _exist(found):
            raise UsageError(f"{found.folder}: holds no outputs; make them with pronk render")
        return found
    scene = Manifest.read(folder / "manifest.json").entries.get("scene")
    found = Outputs(folder, scene if isinstance(scene, str) else folder.resolve().name)
    if not _exist(found):
        inner = [path for path in sorted(folder.iterdir()) if _exist(Outputs(path, path.name))]
        hint = f"; its folders do: {', '.join(map(str, inner[:3]))}" if inner else ""
        raise UsageError(f"{folder}: holds no outputs of a scene{hint}")
    return found


def _exist(outputs: Outputs) -> bool:
    # False for names that are too long, unlike the methods of paths.
    return any(map(os.path.exists, (outputs.manifest, outputs.take, outputs.frames)))


def verify(outputs: Outputs, reporter: Reporter) -> Verdict:
    """Check all outputs of a scene.

    A run after it makes again what is damaged, also where size and time of the file do not tell.

    Raises:
        OutputsDamaged: files are missing or damaged.
        StoreError: another run is at work in the folder.
    """
    with contextlib.ExitStack() as lock:
        # In a folder that nobody may write to nobody is at work.
        with contextlib.suppress(OSError):
            lock.enter_context(locked(outputs))
        check = _Check(outputs, Manifest.read(outputs.manifest))
        check.run(reporter)
        for remark in check.remarks:
            reporter.note(remark)
        if check.faults:
            check.mark()
            faults = sorted(check.faults, key=lambda fault: fault.file)
            raise OutputsDamaged(outputs.folder, outputs.name, check.count, faults)
    return Verdict(check.count, tuple(check.films), tuple(check.remarks))


@dataclass
class _Check:
    """A verification under way.

    Attributes:
        outputs: that are checked.
        manifest: of them.
        faults: found so far.
        remarks: on what cannot be judged.
        films: names of films that were compared.
        count: number of files.
        clips: the checks of a sequence's clips, whose faults are among its own.
    """

    outputs: Outputs
    manifest: Manifest
    faults: list[Fault] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    films: list[str] = field(default_factory=list)
    count: int = 0
    clips: list[_Check] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.records = FileRecords(self.outputs.folder, self.manifest.files)
        self.sources = film_sources(self.manifest.entries)

    def run(self, reporter: Reporter) -> None:
        """Check files, then films against those that are whole."""
        self._check_clips(reporter)
        self._check_manifest()
        names = sorted({*self.records, *self._unrecorded()})
        self.count += len(names) + 1
        with stage(reporter, "verify", len(names) + len(self.sources), "files") as current:
            self._check_files(names, current)
            self._check_films(current)
            bad = len(self.faults)
            current.result = f"{self.count} files, {bad or 'none'} damaged or missing"

    def _check_clips(self, reporter: Reporter) -> None:
        """Check the outputs of the clips of a sequence, which are within its own."""
        sequences = [one for one in self.sources.values() if isinstance(one, SequenceSource)]
        for outputs in (clip.outputs(self.outputs) for one in sequences for clip in one.clips):
            check = _Check(outputs, Manifest.read(outputs.manifest))
            check.run(reporter)
            self.clips.append(check)
            self.count += check.count
            self.remarks += check.remarks
            place = self.records.name(outputs.folder)
            self.faults += [
                replace(fault, file=f"{place}/{fault.file}", remedy="") for fault in check.faults
            ]

    def mark(self) -> None:
        """Have the next run read what is damaged, if the manifest can be written."""
        for clip in self.clips:
            if clip.faults:
                clip.mark()
        if not self.manifest.is_sealed or not self.outputs.manifest.exists():
            # It counts for nothing, and its files are all read.
            return
        for fault in self.faults:
            self.records.distrust(self.outputs.folder / fault.file)
            # What is as it was written was written wrong.
            self.records.forget_intact(self.outputs.folder / fault.file)
        self.manifest.files = self.records
        try:
            write_if_changed(self.outputs.manifest, self.manifest.encoded())
        except OSError as error:
            self.remarks.append(f"{self.outputs.manifest}: cannot be written ({error.strerror})")

    def _check_manifest(self) -> None:
        name = self.outputs.manifest.name
        if not self.outputs.manifest.exists():
            self.faults.append(Fault(name, MISSING))
        elif not self.manifest.is_sealed:
            self.faults.append(Fault(name, NOT_AS_WRITTEN))
        elif not self.records:
            self.remarks.append(f"{name}: an earlier version wrote it, which recorded no files")

    def _unrecorded(self) -> Iterator[str]:
        """Yield the names of outputs that have no record, of a run that was stopped."""
        outputs, folder = self.outputs, self.outputs.folder
        others = (outputs.take, outputs.midi, outputs.wav, outputs.events, outputs.event_table)
        films = (p for p in folder.glob(f"{glob.escape(outputs.name)}*") if p.suffix in CONTAINERS)
        for path in (*outputs.frames.glob("*"), *others, *films):
            name = self.records.name(path)
            is_output = is_frame(path) or path.parent == folder
            if path.exists() and is_output and name not in self.records:
                yield name

    def _check_files(self, names: list[str], current: Stage) -> None:
        unjudged = 0
        for done, name in enumerate(names, start=1):
            text = fault_of(self.outputs, self.outputs.folder / name, self.records.get(name))
            unjudged += text is None
            if text:
                self.faults.append(Fault(name, text, self._remedy(name)))
            current.advance(done)
        if unjudged:
            self.remarks.append(f"{unjudged} files have no record and cannot be judged")

    def _check_films(self, current: Stage) -> None:
        damaged = {fault.file for fault in self.faults}
        for name, source in sorted(self.sources.items()):
            current.advance(current.done + 1)
            if name in damaged or name not in self.records:
                continue
            if not is_current(name, source, self.outputs, self.records):
                self.remarks.append(f"{name}: older than its frames or sound, and not compared")
                continue
            self.films.append(name)
            for text in film_faults(name, source, self.outputs, damaged):
                self.faults.append(Fault(name, text, self._remedy(name)))

    def _remedy(self, name: str) -> str:
        """Return what makes a file again, "" where `pronk render` does."""
        outputs = self.outputs
        own = (outputs.take, outputs.midi, outputs.wav, outputs.events, outputs.event_table)
        cues = (outputs.edit_list, outputs.labels, *map(outputs.surround, LAYOUTS))
        films = (outputs.film(suffix=suffix) for suffix in CONTAINERS)
        path = outputs.folder / name
        if is_frame(path) or path in (*own, *cues, *films):
            return ""
        source = self.sources.get(name)
        if isinstance(source, FilmSource):
            text = source.facts["frames"]
            return f"pronk render {outputs.name} --frames {text}"
        return "its own command writes it again"
