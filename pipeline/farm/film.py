"""Film of a farm: a scene and its take under one key, and where the store keeps what is made of it.

takes/TAKE.tar                    the take, all rows
films/FILM/film.json              the scene, its files, its take
films/FILM/tracks.tar             camera poses and footprints of the whole film
films/FILM/renderer.json          the class of renderers that began the film
films/FILM/frames/0001-CLASS.json which picture is frame 1, with its digest
films/FILM/failures/0001.json     why frame 1 was given up
films/FILM/segments/0001-0240.json  which segment is frames 1 to 240
films/FILM/costs/ID.json          what a part of the film has cost
frames/FRAME.png                  pictures, under the keys of their contents
segments/SEGMENT.mp4              encoded segments, under the keys of their frames and their codec
segments/SEGMENT.json             their digests
files/DIGEST/NAME                 files that scenes name
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import pipeline
from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import StoreError
from pipeline.farm.seals import digest_of
from pipeline.farm.store import ObjectMissing, Store
from pipeline.production.run.take_stage import take_key
from pipeline.spec import Scene, dump, read_scene
from pipeline.spec.file_references import file_names
from pipeline.user_cache import user_cache_folder


@dataclass(frozen=True, slots=True)
class Film:
    """A film that a farm makes.

    Attributes:
        key: digest of the scene, its files, the key of its take and pronk's version.
        name: of the scene.
        take: key of its take.
        scene: as text, with names of files that lead into the store.
        files: digests of these files, by their names in the text.
        frames: number of frames.
        rate: frames a second.
        size: of the frames [pixels].
        format: of the frames, "png" or "exr".
        pronk: version that the film is made with.
    """

    key: str
    name: str
    take: str
    scene: str
    files: Mapping[str, str]
    frames: int
    rate: Fraction
    size: tuple[int, int]
    format: str
    pronk: str

    @property
    def folder(self) -> str:
        """Folder of the film in the store."""
        return f"films/{self.key}"

    def frame_object(self, key: str) -> str:
        """Return the name of a picture."""
        return f"frames/{key}.{self.format}"

    @property
    def facts(self) -> dict[str, Any]:
        """Its members as JSON has them."""
        plain = {**asdict(self), "rate": str(self.rate), "size": list(self.size)}
        return {**plain, "files": dict(self.files)}


def film_of(scene: Scene, name: str, take: str | None = None) -> tuple[Film, dict[str, Path]]:
    """Return the film of a scene, and the files that the scene names by their names in its text.

    Args:
        scene: of the film.
        name: of the scene.
        take: key of the take; by default of the one that is simulated on this machine.

    Raises:
        StoreError: a file cannot be read.
    """
    files: dict[str, Path] = {}
    digests: dict[str, str] = {}
    names: dict[str, str] = {}
    for _, path in file_names(scene):
        digest = _digest_of_file(Path(path))
        names[path] = inside = f"files/{digest}/{Path(path).name}"
        files[inside], digests[inside] = Path(path), digest
    text, take = dump(scene, in_full=False, files=names), take or take_key(scene)
    content = f"{text}|{take}|{pipeline.__version__}"
    film = scene.film.resolved()
    key = hashlib.blake2b(content.encode(), digest_size=16).hexdigest()
    return (
        Film(
            key=key,
            name=name,
            take=take,
            scene=text,
            files=digests,
            frames=scene.n_frames,
            rate=scene.rate,
            size=film.size,
            format=film.format,
            pronk=pipeline.__version__,
        ),
        files,
    )


def store_film(store: Store, film: Film, files: Mapping[str, Path]) -> None:
    """Store the description of a film and the files of its scene, unless they are there.

    Raises:
        StoreError: one cannot be read or written.
    """
    if store.has(f"{film.folder}/film.json"):
        return
    for name, path in files.items():
        if not store.has(name):
            store.put(name, _content(path))
    # Last, because the others follow from it.
    store.put_json(f"{film.folder}/film.json", film.facts)


def read_film(store: Store, key: str) -> Film:
    """Return a film of the store.

    Raises:
        ObjectMissing: there is none of this key.
        StoreError: it cannot be read.
    """
    facts = store.get_json(f"films/{key}/film.json")
    try:
        rate, size = Fraction(facts["rate"]), tuple(facts["size"])
        return Film(**{**facts, "rate": rate, "size": size})
    except (KeyError, TypeError, ValueError) as error:
        raise StoreError(f"{store.address}: films/{key} is no film ({error})") from error


def scene_of(store: Store, film: Film) -> Scene:
    """Return the scene of a film, with its files fetched into this user's cache.

    Raises:
        StoreError: a file cannot be read.
    """
    folder = user_cache_folder() / "farm"
    for name, digest in film.files.items():
        path = folder / name
        if not path.resolve().is_relative_to(folder.resolve()):
            raise StoreError(f"{store.address}: {film.folder} names a file outside: {name}")
        try:
            if path.is_file() and digest_of(path.read_bytes()) == digest:
                continue
            make_folder(path.parent)
            write_if_changed(path, store.get_checked(name, digest))
        except OSError as error:
            raise StoreError(f"{path}: {error.strerror or error}") from error
    return read_scene(film.scene, f"{film.name}.yaml", folder)


def known_films(store: Store) -> list[Film]:
    """Return the films of a store, in the order of their names.

    Raises:
        StoreError: one cannot be read.
    """
    films = []
    for key in store.folders("films"):
        try:
            films.append(read_film(store, key))
        except ObjectMissing:
            continue  # is being stored now
    return sorted(films, key=lambda film: (film.name, film.key))


def _digest_of_file(path: Path) -> str:
    return digest_of(_content(path))


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise StoreError(f"{path}: {error.strerror or error}") from error
