"""Take stage: the take of a scene, simulated only if the stored one does not fit."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.atomic_file import PARTIAL, remove, replace_folder
from pipeline.errors import StoreError
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.film_end import notes_after_end
from pipeline.production.run.frame_ranges import counted
from pipeline.production.run.notes import NotesRefused, clock_of, take_notes
from pipeline.production.run.progress import stage
from pipeline.production.run.scene_run import SceneRun
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_key, read_take, write_take
from pipeline.simulation.versions import versions
from pipeline.spec import Scene, simulation_key


def take_key(scene: Scene) -> str:
    """Return the key of a scene's take: a digest of the simulated settings and the versions."""
    text = f"{simulation_key(scene)}|{sorted(versions().items())}"
    return hashlib.blake2b(text.encode(), digest_size=20).hexdigest()


def take_of(run: SceneRun) -> Take:
    """Return the take of the scene, simulating only if the stored one does not fit.

    Raises:
        NotesRefused: there are notes and the order is strict; a new take is stored apart.
        SimulationError: the scene cannot be simulated.
    """
    scene = run.order.scene
    clock = clock_of(scene)
    key = take_key(scene)
    run.notes = notes_after_end(scene)
    with stage(run.reporter, "simulate", scene.n_frames, "s", float(1 / scene.rate)) as current:
        stored = _whole_take(run, key)
        if stored is not None:
            current.keep(scene.n_frames)
            current.result = "take is up to date"
            run.notes += take_notes(stored, clock)
            run.refuse_notes()
            _accept_take(run, key)
            run.describe(stored)
            return stored
        with compile_progress(run.reporter, current) as compiling:

            def progress(done: int, _: int) -> None:
                compiling.close()
                current.advance(done)

            take = simulate(scene, key, progress)
        current.done = scene.n_frames
        current.result = (
            f"{counted(scene.n_frames)}, playing for {float(scene.n_frames / scene.rate):.1f} s"
        )
        run.notes += take_notes(take, clock)
        try:
            run.refuse_notes()
        except NotesRefused:
            # It need not be simulated again, and earlier outputs stay.
            write_stored(take, run.outputs.refused_take)
            run.records.add(run.outputs.refused_take, key)
            raise
        run.record_time(current)
        store_take(run, take)
    return take


def store_take(run: SceneRun, take: Take) -> None:
    """Store a take in place of an earlier one, and describe it in the manifest."""
    write_stored(take, run.outputs.take)
    remove(run.outputs.refused_take)
    remove(run.outputs.early_take)
    _remove_cues(run, take.header.key)
    run.records.add(run.outputs.take, take.header.key)
    run.describe(take)


def adopt_take(run: SceneRun, key: str, fetch: Callable[[Path], None]) -> Take:
    """Return the take of a key that was simulated elsewhere, fetched only if it is not stored.

    Args:
        run: on the scene.
        key: of the take.
        fetch: writes the take into a new folder.

    Raises:
        NotesRefused: there are notes and the order is strict.
    """
    run.notes = notes_after_end(run.order.scene)
    take = _whole_take(run, key)
    if take is None:
        new = run.outputs.take.with_name(f".{run.outputs.take.name}{PARTIAL}")
        remove(new)
        fetch(new)
        replace_folder(new, run.outputs.take)
        _remove_cues(run, key)
        take = read_take(run.outputs.take)
        run.records.add(run.outputs.take, key)
    else:
        _accept_take(run, key)
    remove(run.outputs.refused_take)
    run.describe(take)
    run.notes += take_notes(take, clock_of(run.order.scene))
    run.refuse_notes()
    return take


def _remove_cues(run: SceneRun, key: str) -> None:
    """Remove labels and edit list of another take than that of a key."""
    if run.records.of(run.outputs.take, key) is not None:
        return
    cues = run.outputs.labels, run.outputs.edit_list
    for path in cues:
        remove(path)
    run.records.update(*cues)


def write_stored(take: Take, place: Path) -> None:
    """Write a take to a place among the outputs, whole or not at all."""
    new = place.with_name(f".{place.name}{PARTIAL}")
    write_take(take, new)
    replace_folder(new, place)


def kept_take(run: SceneRun, key: str) -> bool:
    """Return whether the whole take of a key seems to be stored."""
    try:
        return key in map(read_key, (run.outputs.take, run.outputs.refused_take))
    except Exception:
        # A damaged file can raise anything, and a take can be made again.
        return False


def _whole_take(run: SceneRun, key: str) -> Take | None:
    return stored_take(run, key, (run.outputs.take, run.outputs.refused_take))


def stored_take(run: SceneRun, key: str, places: Sequence[Path]) -> Take | None:
    """Return the take that an earlier run stored under `key` in a place, None if there is none."""
    for place in places:
        try:
            if read_key(place) == key:
                take = read_take(place)
                if run.records.of(place, key) and not run.records.is_intact(place, key):
                    raise StoreError(f"{place}: the take is damaged: it is not as it was written")
                return take
        except StoreError as error:
            run.reporter.note(f"{error}; it is made again")
        except Exception as error:
            # A damaged file can raise anything, and a take can be made again.
            run.reporter.note(f"{place}: is no take that can be read ({error}); it is made again")
    return None


def _accept_take(run: SceneRun, key: str) -> None:
    """Make the take that a strict run refused the take of the film, if it is the one in use."""
    if read_key(run.outputs.take) != key:
        replace_folder(run.outputs.refused_take, run.outputs.take)
        _remove_cues(run, key)
    if run.records.of(run.outputs.take, key) is None:
        run.records.add(run.outputs.take, key)
