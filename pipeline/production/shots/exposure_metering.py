"""Metering: the exposure of each cut of a film, from small pictures of it.

A cut has one exposure, so that nothing brightens or darkens while it lasts.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace

from pipeline.production.shots.shot_builder import ShotBuilder
from render.config import Film
from render.development import Tone
from render.exposure_meter import daylight, metered_tone
from render.lights.environment_map import sky_width
from render.renderer import Renderer
from render.shot import Shot

PARTS = (0.12, 0.5, 0.88)
"""Moments of a cut at which it is metered, as shares of its length."""


def metered_tones(builder: ShotBuilder, renderer: Renderer) -> tuple[Tone, ...]:
    """Return the tone of each frame of a film.

    Raises:
        RenderError: a frame cannot be rendered.
    """
    share, look = daylight(builder.light), builder.film.look
    tones: list[Tone] = []
    for cut in builder.cuts:
        pictures = [renderer.measure(shot) for shot in _shots(builder, cut)] if share > 0 else []
        tone = metered_tone(pictures, look, share) if pictures else Tone()
        tones += [tone] * len(cut)
    return tuple(tones)


def metering_key(builder: ShotBuilder, extra: str) -> str:
    """Return the key of the tones of a film, a digest of all that they depend on.

    Args:
        builder: of the shots.
        extra: what frames depend on besides their shots.
    """
    state = hashlib.blake2b(extra.encode(), digest_size=16)
    # Of the frame otherwise only its shape counts.
    width, height = builder.film.size
    # The sky is painted finer for large frames.
    state.update(f"{sky_width(width)}".encode())
    film = Film(size=(320, 2 * max(round(160 * height / width), 8)), look=builder.film.look)
    for cut in builder.cuts:
        state.update(f"{cut}".encode())
        for shot in _shots(builder, cut):
            state.update(
                replace(shot, film=film, later=(), after=None, tone=Tone()).digest.encode()
            )
    return state.hexdigest()


def _shots(builder: ShotBuilder, cut: range) -> Iterator[Shot]:
    """Yield the shots of a cut that are metered."""
    for frame in sorted({cut[int(part * len(cut))] for part in PARTS}):
        yield builder.shot(frame)
