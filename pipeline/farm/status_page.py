"""Status page: how far the films of a store are, with thumbnails, as one HTML file."""

from __future__ import annotations

import base64
import html
import io
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.errors import StoreError
from pipeline.farm.frame_index import FrameIndex
from pipeline.farm.status import FilmStatus
from pipeline.farm.store import Store
from pipeline.production.run.quantities import duration_text
from render.development import developed
from render.errors import RenderError
from render.image_files import read_development, read_exr, read_png

THUMBNAILS = 12
"""Most thumbnails of a film."""

WIDTH = 192
"""Of a thumbnail [pixels]."""

QUALITY = 80
"""Of a thumbnail, as JPEG has it."""

REFRESH = 10
"""Time after which a browser reads the page again [s]."""

STYLE = """
body { font: 15px system-ui, sans-serif; margin: 2em; background: #16181c; color: #e4e6ea }
h2 { font-size: 1.1em; margin: 1.6em 0 .3em } small { color: #9aa0aa }
progress { width: 24em; vertical-align: middle } .failed { color: #ff8a80 }
figure { display: inline-block; margin: .3em .4em .3em 0 } figcaption { color: #9aa0aa }
img { display: block; width: 192px; border-radius: 3px }
"""


class StatusPage:
    """Writes the page; keeps thumbnails, so that each picture is read once.

    Args:
        store: of the farm.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._thumbnails: dict[tuple[str, int], str] = {}

    def text(self, found: Sequence[FilmStatus], written: str) -> str:
        """Return the page.

        Args:
            found: how far the films are.
            written: when, for people.
        """
        films = "".join(map(self._film, found)) or "<p>The store has no films.</p>"
        return (
            "<!doctype html>\n<html lang=en><meta charset=utf-8>"
            f"<meta http-equiv=refresh content={REFRESH}>"
            "<meta http-equiv=content-security-policy "
            "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">"
            f"<title>pronk farm</title><style>{STYLE}</style>"
            f"<h1>pronk farm</h1><small>{html.escape(self._store.address)}, "
            f"{html.escape(written)}</small>{films}</html>\n"
        )

    def _film(self, status: FilmStatus) -> str:
        film = status.film
        rate = "" if status.rate is None else f", {status.rate:.2f} frames a second"
        left = "" if status.remaining is None else f", {duration_text(status.remaining)} left"
        failures = "".join(
            f"<div class=failed>frame {frame}: {html.escape(reason)}</div>"
            for frame, reason in status.failures.items()
        )
        pictures = "".join(self._figure(status, frame) for frame in _spread(status.done))
        return (
            f"<h2>{html.escape(film.name)} <small>{film.key[:8]}</small></h2>"
            f"<progress max={film.frames} value={len(status.done)}></progress> "
            f"{len(status.done)} of {film.frames} frames{rate}{left}: {html.escape(status.state)}"
            f"{failures}<div>{pictures}</div>"
        )

    def _figure(self, status: FilmStatus, frame: int) -> str:
        key = status.film.key, frame
        if key not in self._thumbnails:
            try:
                self._thumbnails[key] = self._thumbnail(status, frame)
            except (StoreError, RenderError, OSError, ValueError):
                return f"<figure><figcaption>{frame}: cannot be read</figcaption></figure>"
        data = self._thumbnails[key]
        return (
            f'<figure><img alt="frame {frame}" src="data:image/jpeg;base64,{data}">'
            f"<figcaption>{frame}</figcaption></figure>"
        )

    def _thumbnail(self, status: FilmStatus, frame: int) -> str:
        film = status.film
        (record,) = FrameIndex(self._store, film).records([frame], None)
        data = self._store.get_checked(film.frame_object(record.key), record.digest)
        with tempfile.TemporaryDirectory(prefix="pronk_page_") as made:
            path = Path(made, f"frame.{film.format}")
            path.write_bytes(data)
            if film.format == "exr":
                picture = developed(read_exr(path), read_development(path))
            else:
                picture = read_png(path)
        image = Image.fromarray(np.ascontiguousarray(picture[..., :3]))
        image.thumbnail((WIDTH, 4 * WIDTH))
        packed = io.BytesIO()
        image.convert("RGB").save(packed, "JPEG", quality=QUALITY)
        return base64.b64encode(packed.getvalue()).decode()


def _spread(frames: Sequence[int]) -> list[int]:
    """Return some frames spread evenly over those that are done, the last one among them."""
    count = min(len(frames), THUMBNAILS)
    return [frames[round((len(frames) - 1) * k / max(count - 1, 1))] for k in range(count)]
