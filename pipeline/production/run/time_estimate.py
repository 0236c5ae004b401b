"""Time estimate of a film, given before rendering starts and corrected on the way.

Before the first frame it comes from earlier frames of this film on this machine, or else from
other films for the same work; the first frames correct it.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field

from pipeline.atomic_file import write_if_changed
from pipeline.production.run.frame_ranges import counted
from render.backend import Backend, cache_folder
from render.config import FullFilm

MIN_DURATION = 10.0
"""Shorter films are over before an estimate is read [s]."""

MIN_REMAINING = 30.0
"""Time left below which estimates are not corrected [s]."""

MAX_ERROR_RATIO = 1.25
"""Ratio of the measured to the estimated pace from which on an estimate is corrected."""

MIN_MEASURED_FRAMES = 3
"""Frames after the first whose mean time is trusted."""

MIN_MEGAPIXELS = 0.05
"""Size from which on the time of a frame is for its pixels and predicts that of other films."""

MAX_PACES = 400
"""Paces that are stored; the oldest are dropped first."""

_START = "|start"
"""Stands for the scene's name in the key of the start-up time of any film."""

_DENOISING_WORK = {"off": 0.0, "fast": 1.0, "high": 2.0}


@dataclass(slots=True)
class Estimate:
    """Time that the frames of one film take.

    Attributes:
        name: of the scene.
        film: size and quality.
        backend: of the renderer.
        jobs: number of processes.
        total: frames that are due.
        measured: time per frame [s], None before it is known.
        reported: time per frame that was last reported [s], None if none was.
        start: time before the first frame [s].
    """

    name: str
    film: FullFilm
    backend: Backend
    jobs: int
    total: int
    measured: float | None = None
    reported: float | None = None
    start: float = 0.0
    _first: tuple[int, float] | None = field(default=None)

    def before(self) -> str | None:
        """Return the estimate before the first frame, None if there is none or it is short."""
        paces = stored_paces()
        own, other = paces.get(self._key(self.name)), paces.get(self._key(""))
        self.start = paces.get(self._key(_START), 0.0)
        if own is not None:
            self.reported = own
            return self._text(self.total, "by the last time")
        if other is not None:
            self.reported = other * frame_work(self.film)
            return self._text(self.total, "by other films on this machine")
        return None

    def after(self, done: int, seconds: float) -> str | None:
        """Return a correction of the estimate, None if none is needed.

        Args:
            done: frames that are rendered.
            seconds: time since rendering started [s].
        """
        if self._first is None:
            # Until the first frames are done, scenes are built and kernels compiled.
            self._first = done, seconds
            return None
        self.start = 0.0
        count = done - self._first[0]
        if count < MIN_MEASURED_FRAMES:
            return None
        self.measured = (seconds - self._first[1]) / count
        if self.reported is not None:
            ratio = self.measured / max(self.reported, 1e-9)
            if 1 / MAX_ERROR_RATIO < ratio < MAX_ERROR_RATIO:
                return None
        self.reported = self.measured
        if self.measured * (self.total - done) < MIN_REMAINING:
            return None
        return self._text(self.total - done, "by the first of them")

    def store(self) -> None:
        """Store what was measured for later estimates."""
        if self.measured is None or self._first is None:
            return
        paces = stored_paces()
        # Compiling kernels makes the first start long, and later ones short.
        start = max(self._first[1] - self.measured * self._first[0], 1e-3)
        found = {
            self.name: self.measured,
            _START: min(start, paces.get(self._key(_START), start)),
        }
        if self.film.size[0] * self.film.size[1] >= MIN_MEGAPIXELS * 1e6:
            found[""] = self.measured / frame_work(self.film)
        for name, pace in found.items():
            paces.pop(self._key(name), None)
            paces[self._key(name)] = pace
        place = cache_folder() / "paces.json"
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            write_if_changed(place, json.dumps(dict(list(paces.items())[-MAX_PACES:])).encode())
        except OSError:
            pass  # Without it the next estimate comes later.

    def _text(self, frames: int, source: str) -> str | None:
        seconds = self.start + (self.reported or 0.0) * frames
        if seconds < MIN_DURATION:
            return None
        width, height = self.film.size
        size = f"{counted(frames)} of {width}x{height}"
        return f"render: about {rounded_duration(seconds)} for {size}, {source}"

    def _key(self, name: str) -> str:
        """Return the key of a scene's pace; of any scene's for no name."""
        film = self.film.model_dump_json(exclude={"preset", "codec", "format", "exposure"})
        text = f"{name}|{film if name not in ('', _START) else ''}|{self.backend.key}|{self.jobs}"
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


def frame_work(film: FullFilm) -> float:
    """Return the work of a frame, in units of about a megapixel of one path with its rays."""
    width, height = film.size
    soft = 0.25 if film.soft_light == "half" else 1.0
    # A camera ray with its lamps takes half the time of a step of a path.
    traced = film.passes * (film.rays * 0.5 + soft * film.depth)
    return width * height / 1e6 * (traced / 6 + soft * _DENOISING_WORK[film.denoise])


def stored_paces() -> dict[str, float]:
    """Return times per frame, or per unit of work, by key; the latest come last."""
    try:
        found = json.loads((cache_folder() / "paces.json").read_text())
        return {str(key): float(pace) for key, pace in found.items() if float(pace) > 0}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def rounded_duration(seconds: float) -> str:
    """Return a rounded duration, such as 40 s, 12 min, 3 h 20 min."""
    if seconds < 90:
        return f"{max(round(seconds / 5) * 5, 5)} s"
    minutes = round(seconds / 60)
    if minutes < 120:
        return f"{minutes} min"
    return f"{minutes // 60} h {round(minutes % 60, -1) % 60} min"
