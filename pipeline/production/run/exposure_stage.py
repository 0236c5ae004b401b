"""Exposure stage: the exposure of each cut, metered once and kept in the manifest."""

from __future__ import annotations

from dataclasses import asdict

from pipeline.errors import FilmingError
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.scene_run import SceneRun
from pipeline.production.shots.exposure_metering import metered_tones, metering_key
from pipeline.production.shots.shot_builder import ShotBuilder
from render.development import Tone
from render.errors import DeviceMemoryShort, RenderError
from render.renderer import Renderer

ENTRY = "exposure"
"""Entry of the manifest."""


def expose(run: SceneRun, shooting: ShotBuilder, renderer: Renderer) -> None:
    """Set the exposure of each frame, as metered now or by an earlier run of the same film.

    Raises:
        FilmingError: a frame cannot be rendered.
        DeviceMemoryShort: the GPU has too little memory.
    """
    key = metering_key(shooting, renderer.key_extra)
    tones = _kept(run.manifest.entries.get(ENTRY), key, shooting)
    if tones is None:
        try:
            with held_back():
                tones = metered_tones(shooting, renderer)
        except DeviceMemoryShort:
            raise
        except (RenderError, OSError) as error:
            raise FilmingError(str(error)) from error
    shooting.set_tones(tones)
    enter_exposure(run, shooting, renderer.key_extra)


def enter_exposure(run: SceneRun, shooting: ShotBuilder, extra: str) -> None:
    """Enter the exposure of each cut into the manifest.

    Args:
        run: of the scene.
        shooting: with the tones of all frames.
        extra: what its frames depend on besides their shots.
    """
    cuts = [shooting.tracks.tones[cut.start - 1] for cut in shooting.cuts]
    facts = [asdict(tone) for tone in cuts]
    run.manifest.entries[ENTRY] = {"key": metering_key(shooting, extra), "cuts": facts}


def _kept(entry: object, key: str, shooting: ShotBuilder) -> tuple[Tone, ...] | None:
    """Return the tones of all frames that an earlier run entered, None if they do not fit."""
    match entry:
        case {"key": str(known), "cuts": [*facts]} if known == key:
            try:
                kept = [Tone(**{name: float(value) for name, value in f.items()}) for f in facts]
                cuts = zip(kept, shooting.cuts, strict=True)
                return tuple(tone for tone, cut in cuts for _ in cut)
            except (TypeError, AttributeError, ValueError):
                return None  # of a manifest that was written by others
    return None
