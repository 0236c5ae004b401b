"""Frame index: the frames of a film that are in the store, their renderers, and failures."""

from __future__ import annotations

import re
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Any

from pipeline.errors import ProductionError, StoreError
from pipeline.farm.film import Film
from pipeline.farm.seals import digest_of, sealed
from pipeline.farm.store import Store

READERS = 8
"""Requests to the store at once."""

_RECORD = re.compile(r"([0-9]{4,})-([0-9a-f]{8})\.json")
_FAILURE = re.compile(r"([0-9]{4,})\.json")


class MixedClasses(ProductionError):
    """Renderers of several classes would make one film."""


@dataclass(frozen=True, slots=True)
class FrameRecord:
    """A frame of a film.

    Attributes:
        frame: its number.
        key: digest of all that the picture depends on.
        digest: of the file.
        size: of the file [bytes].
        renderer: all that the picture depends on besides its shot.
        seconds: that the frame took, 0.0 for one that was there.
    """

    frame: int
    key: str
    digest: str
    size: int
    renderer: str
    seconds: float = 0.0

    @property
    def name(self) -> str:
        """Its name in the folder of frames."""
        return f"{self.frame:04d}-{class_of(self.renderer)}.json"


def class_of(renderer: str) -> str:
    """Return the name of a class of renderers: equal ones make equal pictures of equal shots."""
    return digest_of(renderer.encode())[:8]


class FrameIndex:
    """The frames of one film in a store.

    Args:
        store: that has them.
        film: that they belong to.
    """

    def __init__(self, store: Store, film: Film) -> None:
        self._store, self._film = store, film
        self._folder = f"{film.folder}/frames"

    def done(self) -> dict[int, set[str]]:
        """Return the classes of renderers of which each frame that is there has pictures."""
        found: dict[int, set[str]] = {}
        for name in self._store.names(self._folder):
            match = _RECORD.fullmatch(name)
            if match:
                found.setdefault(int(match[1]), set()).add(match[2])
        return found

    def times(self) -> dict[int, float]:
        """Return when each frame that is there was written, since the epoch [s]."""
        entries = self._store.names(self._folder)
        found = {n: m for n in entries if (m := _RECORD.fullmatch(n)) is not None}
        return {int(match[1]): entries[name].time for name, match in found.items()}

    def put(self, record: FrameRecord) -> None:
        """Record a frame whose picture is stored."""
        self._store.put_json(f"{self._folder}/{record.name}", asdict(record))

    def forget(self, record: FrameRecord) -> None:
        """Drop the record of a frame whose picture is damaged or gone."""
        self._store.remove(f"{self._folder}/{record.name}")

    def records(self, frames: Iterable[int], renderer_class: str | None) -> list[FrameRecord]:
        """Return the records of frames that are there.

        Args:
            frames: that have a record.
            renderer_class: of the pictures, None for any.

        Raises:
            StoreError: one cannot be read.
        """
        done = self.done()
        names = [
            f"{self._folder}/{frame:04d}-{renderer_class or min(done[frame])}.json"
            for frame in frames
        ]
        with ThreadPoolExecutor(READERS) as pool:
            return [self._record(members) for members in pool.map(self._store.get_json, names)]

    def _record(self, members: dict[str, Any]) -> FrameRecord:
        try:
            return FrameRecord(**members)
        except TypeError as error:
            raise StoreError(f"{self._store.address}: a record of a frame is none ({error})") from (
                error
            )

    def whole_class(self, frames: Iterable[int], mixed: bool) -> str | None:
        """Return the class of renderers that made all frames; None for `mixed` ones.

        Args:
            frames: all of them are there.
            mixed: whether classes may be mixed; one that made all frames goes before.

        Raises:
            MixedClasses: no class made all frames.
        """
        done = self.done()
        common = set.intersection(*(done[frame] for frame in frames))
        if common:
            return min(common)
        if mixed:
            return None
        classes = sorted(set().union(*(done[frame] for frame in frames)))
        raise MixedClasses(
            f"{self._film.name}: its frames were rendered by {len(classes)} classes of processors "
            f"or versions ({', '.join(classes)}), none of which made all; --mixed takes them all, "
            "and 'pronk farm frames' on one class makes the others"
        )

    def begin_class(self, renderer: str, mixed: bool) -> None:
        """Note the class of renderers that begins the film, or require it.

        Args:
            renderer: all that a picture depends on besides its shot.
            mixed: whether other classes may go on with the film.

        Raises:
            MixedClasses: a renderer of another class began the film.
        """
        name = f"{self._film.folder}/renderer.json"
        self._store.create(name, sealed({"renderer": renderer}))
        first = str(self._store.get_json(name).get("renderer"))
        if first != renderer and not mixed:
            raise MixedClasses(
                f"{self._film.name}: the film was begun by another class of processor or version "
                f"({first}) than this one ({renderer}); give --mixed to mix them"
            )

    def failures(self) -> dict[int, str]:
        """Return why frames were given up."""
        folder = f"{self._film.folder}/failures"
        found = {n: m for n in self._store.names(folder) if (m := _FAILURE.fullmatch(n))}
        return {
            int(match[1]): str(self._store.get_json(f"{folder}/{name}").get("reason"))
            for name, match in sorted(found.items())
        }

    def fail(self, frame: int, reason: str, tries: int) -> None:
        """Note that a frame was given up."""
        members = {"frame": frame, "reason": reason, "tries": tries}
        self._store.put_json(f"{self._film.folder}/failures/{frame:04d}.json", members)

    def forget_failures(self, frames: Iterable[int]) -> None:
        """Forget that frames were given up, because they are there now or tried again."""
        for frame in frames:
            self._store.remove(f"{self._film.folder}/failures/{frame:04d}.json")
