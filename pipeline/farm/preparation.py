"""Preparation of a film: its scene, its take and its tracks in the store."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import ProductionError, StoreError
from pipeline.farm.archive import write_arrays
from pipeline.farm.film import Film, store_film
from pipeline.farm.store import Store
from pipeline.farm.take_object import fetch_take, store_take, take_name
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.film_end import notes_after_end
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.notes import Note, clock_of, read_notes, take_notes
from pipeline.production.run.picture_notes import shooting_notes
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.scene_run import translated_errors
from pipeline.production.run.take_stage import take_key
from pipeline.production.shots.exposure_metering import metered_tones
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_take
from pipeline.spec import Scene
from render.backend import choose
from render.development import Tone
from render.renderer import Renderer


@dataclass(frozen=True, slots=True)
class Prepared:
    """A film whose frames can be rendered.

    Attributes:
        simulated: whether the scene was simulated now.
        notes: on the scene, its take and its camera.
    """

    simulated: bool
    notes: tuple[Note, ...]


def tracks_name(film: Film) -> str:
    """Return the name of the tracks of a film."""
    return f"{film.folder}/tracks.tar"


def notes_name(film: Film) -> str:
    """Return the name of the notes on a film."""
    return f"{film.folder}/notes.json"


def stored_notes(store: Store, film: Film) -> tuple[Note, ...]:
    """Return the notes on a film that is prepared.

    Raises:
        StoreError: they cannot be read.
    """
    return tuple(read_notes(store.get_json(notes_name(film)).get("notes")))


def is_prepared(store: Store, film: Film) -> bool:
    """Return whether frames of a film can be rendered."""
    # The tracks are stored last.
    return store.has(tracks_name(film)) and store.has(take_name(film.take))


def prepare(
    store: Store,
    film: Film,
    scene: Scene,
    files: dict[str, Path],
    reporter: Reporter,
) -> Prepared:
    """Store the scene, take and tracks of a film, simulating if the store has no take of it.

    Args:
        store: of the farm.
        film: of the scene.
        scene: of the film.
        files: that the scene names, by their names in the store.
        reporter: of the progress.

    Raises:
        ProductionError: the take would be another one on this machine.
        SimulationError: the scene cannot be simulated.
        StoreError: something cannot be read or written.
    """
    with stage(reporter, "simulate", film.frames, "s", float(1 / film.rate)) as current:
        if is_prepared(store, film) and store.has(f"{film.folder}/film.json"):
            current.keep(film.frames)
            current.result = "take is in the store"
            return Prepared(False, stored_notes(store, film))
        simulated = not store.has(take_name(film.take))
        if simulated:
            _require_class(scene, film)
            with compile_progress(reporter, current) as compiling:

                def progress(done: int, _: int) -> None:
                    compiling.close()
                    current.advance(done)

                take = simulate(scene, film.take, progress)
            store_take(store, take)
        else:
            take = _stored_take(store, film)
            current.keep(film.frames)
        with translated_errors():
            shooting = ShotBuilder(scene, take)
            notes = (
                *notes_after_end(scene),
                *take_notes(take, clock_of(scene)),
                *shooting_notes(scene, shooting),
            )
            shooting.set_tones(_metered(shooting))
        store_film(store, film, files)
        store.put_json(notes_name(film), {"notes": [note.facts for note in notes]})
        _store_tracks(store, film, shooting)
        current.done = film.frames
        current.result = "take is stored" if simulated else "take is in the store"
    return Prepared(simulated, notes)


def _require_class(scene: Scene, film: Film) -> None:
    """Refuse to make another take than the film asks for.

    Raises:
        ProductionError: this machine would.
    """
    if take_key(scene) != film.take:
        raise ProductionError(
            f"{film.name}: take {film.take} is of another class of processor, another version or "
            "another scene, and the store does not have it; simulate on a machine of its class"
        )


def _stored_take(store: Store, film: Film) -> Take:
    with tempfile.TemporaryDirectory(prefix="pronk_take_") as made:
        folder = Path(made, "take.zarr")
        fetch_take(store, film.take, folder)
        try:
            return read_take(folder)
        except StoreError as error:
            raise StoreError(f"{store.address}: {take_name(film.take)}: {error}") from error


def _metered(shooting: ShotBuilder) -> tuple[Tone, ...]:
    """Return the exposures, metered once for all workers."""
    with held_back():
        return metered_tones(shooting, Renderer(choose("auto")))


def _store_tracks(store: Store, film: Film, shooting: ShotBuilder) -> None:
    with tempfile.TemporaryDirectory(prefix="pronk_tracks_") as made:
        packed = Path(made, "tracks.tar")
        write_arrays(packed, shooting.tracks.arrays())
        store.put(tracks_name(film), packed)
