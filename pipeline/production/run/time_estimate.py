"""Estimate: how long a film will take, said before it starts and put right as it goes on.

Before the first frame it is judged by what frames of this film took the last time on this
machine, or else by what other films took for the same work; a few frames tell it better.
"""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass, field

from pipeline.production.run.frame_ranges import counted
from render.backend import Backend, cache_folder
from render.config import FullFilm

WORTH = 10.0
"""Films that take less are over before one has read how long they take [s]."""

WRONG = 1.25
"""By this factor an estimate is off before it is put right."""

MEASURED = 3
"""Frames after the first from which on their mean is trusted."""

TELLING = 0.05
"""Size of frames from which on they tell of other films [megapixels]: what smaller ones take is
not for their pixels."""

MOST = 400
"""Paces that are remembered, the oldest forgotten first."""

LATE = 30.0
"""If the rest takes less, an estimate is not put right any more [s]."""

_START = "|start"
"""Stands for the name of a scene where the begin of any film is meant."""

_DENOISING = {"off": 0.0, "fast": 1.0, "high": 2.0}


@dataclass(slots=True)
class Estimate:
    """How long the frames of one film take.

    Attributes:
        name: of the scene.
        film: size and quality.
        backend: what renders.
        jobs: processes at once.
        total: frames that are due.
        each: seconds a frame as far as is known, None as long as nothing is.
        said: seconds a frame that were last told, None if none were.
        start: seconds before the first frame, as far as is known.
    """

    name: str
    film: FullFilm
    backend: Backend
    jobs: int
    total: int
    each: float | None = None
    said: float | None = None
    start: float = 0.0
    _first: tuple[int, float] | None = field(default=None)

    def before(self) -> str | None:
        """Return what is known before the first frame, None if that is nothing or little time."""
        paces = remembered()
        own, other = paces.get(self._key(self.name)), paces.get(self._key(""))
        self.start = paces.get(self._key(_START), 0.0)
        if own is not None:
            self.said = own
            return self._told(self.total, "by the last time")
        if other is not None:
            self.said = other * work_of(self.film)
            return self._told(self.total, "by other films on this machine")
        return None

    def after(self, done: int, seconds: float) -> str | None:
        """Return a better estimate of what is left, None if there is no need of one.

        Args:
            done: frames that are.
            seconds: since the rendering began.
        """
        if self._first is None:
            # Until the first frames are there, scenes are built and kernels compiled.
            self._first = done, seconds
            return None
        self.start = 0.0
        count = done - self._first[0]
        if count < MEASURED:
            return None
        self.each = (seconds - self._first[1]) / count
        if self.said is not None and 1 / WRONG < self.each / max(self.said, 1e-9) < WRONG:
            return None
        self.said = self.each
        # As the end comes near the bar tells enough.
        if self.each * (self.total - done) < LATE:
            return None
        return self._told(self.total - done, "by the first of them")

    def remember(self) -> None:
        """Keep for another time what was measured."""
        if self.each is None or self._first is None:
            return
        paces = remembered()
        # What the first frame took more than the others: scenes built, kernels compiled. That is
        # long once, and short as soon as kernels are kept.
        start = max(self._first[1] - self.each * self._first[0], 1e-3)
        found = {
            self.name: self.each,
            _START: min(start, paces.get(self._key(_START), start)),
        }
        if self.film.size[0] * self.film.size[1] >= TELLING * 1e6:
            found[""] = self.each / work_of(self.film)
        for name, pace in found.items():
            paces.pop(self._key(name), None)
            paces[self._key(name)] = pace
        place = cache_folder() / "paces.json"
        beside = place.with_suffix(f".{os.getpid()}")
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            beside.write_text(json.dumps(dict(list(paces.items())[-MOST:])))
            os.replace(beside, place)
        except OSError:
            pass  # without it the next estimate comes later

    def _told(self, frames: int, why: str) -> str | None:
        seconds = self.start + (self.said or 0.0) * frames
        if seconds < WORTH:
            return None
        width, height = self.film.size
        return f"render: about {spoken(seconds)} for {counted(frames)} of {width}x{height}, {why}"

    def _key(self, name: str) -> str:
        """Return the key of the pace of a scene, or of any scene for no name."""
        film = self.film.model_dump_json(exclude={"preset", "codec", "format", "exposure"})
        words = f"{name}|{film if name not in ('', _START) else ''}|{self.backend.key}|{self.jobs}"
        return hashlib.blake2b(words.encode(), digest_size=8).hexdigest()


def work_of(film: FullFilm) -> float:
    """Return how much work a frame is, in units of about a megapixel of one path with its rays."""
    width, height = film.size
    soft = 0.25 if film.soft_light == "half" else 1.0
    # A ray through a pixel, with its lamps, takes half of what a step of a path does.
    traced = film.passes * (film.rays * 0.5 + soft * film.depth)
    return width * height / 1e6 * (traced / 6 + soft * _DENOISING[film.denoise])


def remembered() -> dict[str, float]:
    """Return seconds a frame, or a unit of work, by keys; those last kept come last."""
    try:
        found = json.loads((cache_folder() / "paces.json").read_text())
        return {str(key): float(pace) for key, pace in found.items() if float(pace) > 0}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def spoken(seconds: float) -> str:
    """Return a length of time as one says it: 40 s, 12 min, 3 h 20 min."""
    if seconds < 90:
        return f"{max(round(seconds / 5) * 5, 5)} s"
    minutes = round(seconds / 60)
    if minutes < 120:
        return f"{minutes} min"
    return f"{minutes // 60} h {round(minutes % 60, -1) % 60} min"
