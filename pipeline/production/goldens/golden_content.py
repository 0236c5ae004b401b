"""Golden content: the layers of a golden and their files."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.atomic_file import PARTIAL, make_folder, replace_folder
from pipeline.errors import StoreError
from pipeline.production.goldens.cue_facts import Cues, read_cues
from pipeline.production.goldens.film_facts import FilmFacts, read_film_facts
from pipeline.production.goldens.golden_card import (
    RESTORE_HINT,
    Card,
    Framing,
    Limits,
    file_digest,
    verify,
)
from pipeline.production.goldens.golden_case import GoldenFolder
from pipeline.production.goldens.motion_file import read_golden, write_golden
from pipeline.production.goldens.motion_golden import MotionGolden
from pipeline.production.goldens.verdict import LAYERS, Layer
from render.comparison.image_statistics import SeedSpread
from render.errors import RenderError
from render.image_files import read_png, write_png

Picture = NDArray[np.uint8]
COMPRESSION = 9
"""Level of deflate: goldens are written seldom and kept for ever."""


@dataclass(frozen=True, eq=False)
class Content:
    """Layers of a golden.

    Attributes:
        scene: name of the scene.
        motion: of the take; with `cues`, the layer of motion.
        cues: camera poses and notes of the score.
        film: the layer of the film.
        framing: of the layer of frames.
        frames: number -> picture.
        environment: `Backend.key`, which their pixels depend on.
        spreads: number -> differences between seeds; may be empty.
        limits: of the frames.
        calibrated: number of seeds that the limits come from.
    """

    scene: str
    motion: MotionGolden | None = None
    cues: Cues | None = None
    film: FilmFacts | None = None
    framing: Framing | None = None
    frames: Mapping[int, Picture] = field(default_factory=dict)
    environment: str = ""
    spreads: Mapping[int, SeedSpread] = field(default_factory=dict)
    limits: Limits = Limits()  # noqa: RUF009 (a frozen value)
    calibrated: int = 0

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The layers that are present."""
        found = {"motion": self.motion, "frames": self.framing, "film": self.film}
        return tuple(layer for layer in LAYERS if found[layer] is not None)


def write_content(content: Content, place: GoldenFolder) -> Card:
    """Write the folder of a golden atomically.

    Raises:
        StoreError: it cannot be written.
    """
    new = GoldenFolder(place.path.with_name(f".{place.path.name}{PARTIAL}"))
    try:
        make_folder(new.path)
        for old in new.path.iterdir():
            old.unlink()
        _write_files(content, new)
        names = sorted(path.name for path in new.path.iterdir())
        card = Card(
            scene=content.scene,
            layers=content.layers,
            limits=content.limits,
            calibrated=content.calibrated,
            frames=content.framing,
            environment=content.environment,
            files={name: file_digest(new.path / name) for name in names},
        ).sealed()
        new.card.write_text(card.encoded(), encoding="utf-8", newline="\n")
        replace_folder(new.path, place.path)
    except RenderError as error:
        raise StoreError(str(error)) from error
    except OSError as error:
        raise StoreError(f"{place.path}: could not be written: {error.strerror}") from error
    return card


def _write_files(content: Content, new: GoldenFolder) -> None:
    if content.motion is not None and content.cues is not None:
        write_golden(content.motion, new.motion)
        new.cues.write_text(content.cues.encoded(), encoding="utf-8", newline="\n")
    if content.film is not None:
        new.film.write_text(content.film.encoded(), encoding="utf-8", newline="\n")
    for number, picture in content.frames.items():
        write_png(new.frame(number), picture, "golden", COMPRESSION)
    if content.spreads:
        packed = {str(number): _packed(spread) for number, spread in content.spreads.items()}
        new.spreads.write_text(json.dumps(packed, indent=1) + "\n", encoding="utf-8", newline="\n")


def files_of(layer: Layer, place: GoldenFolder, card: Card) -> list[str]:
    """Return the names of the files of a layer."""
    if layer == "motion":
        return [place.motion.name, place.cues.name]
    if layer == "film":
        return [place.film.name]
    numbers = card.frames.numbers if card.frames else ()
    spreads = [place.spreads.name] if place.spreads.name in card.files else []
    return [place.frame(number).name for number in numbers] + spreads


def read_content(place: GoldenFolder, card: Card, layers: tuple[Layer, ...] = LAYERS) -> Content:
    """Return those of `layers` that a golden has.

    Raises:
        StoreError: a file is missing, damaged or changed.
    """
    present = [layer for layer in layers if layer in card.layers]
    for layer in present:
        verify(card, place.path, files_of(layer, place, card))
    framing = card.frames if "frames" in present else None
    numbers = framing.numbers if framing else ()
    has_spreads = bool(framing) and place.spreads.name in card.files
    return Content(
        scene=card.scene,
        motion=read_golden(place.motion) if "motion" in present else None,
        cues=read_cues(place.cues) if "motion" in present else None,
        film=read_film_facts(place.film) if "film" in present else None,
        framing=framing,
        frames={number: read_png(place.frame(number)) for number in numbers},
        environment=card.environment if framing else "",
        spreads=_read_spreads(place.spreads) if has_spreads else {},
        limits=card.limits,
        calibrated=card.calibrated if framing else 0,
    )


def _packed(spread: SeedSpread) -> dict[str, Any]:
    values = np.stack([spread.means, np.sqrt(spread.variances)]).astype("<f4")
    packed = base64.b85encode(zlib.compress(values.tobytes(), 9)).decode("ascii")
    return {"count": spread.count, "tiles": list(values.shape[1:3]), "packed": packed}


def _read_spreads(path: Path) -> dict[int, SeedSpread]:
    try:
        members: Any = json.loads(path.read_text(encoding="utf-8"))
        return {int(number): _unpacked(packed) for number, packed in members.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, zlib.error) as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); {RESTORE_HINT}") from None


def _unpacked(members: dict[str, Any]) -> SeedSpread:
    data = zlib.decompress(base64.b85decode(members["packed"]))
    values = np.frombuffer(data, "<f4").reshape(2, *members["tiles"], 3).astype(np.float64)
    return SeedSpread(int(members["count"]), values[0], values[1] ** 2)
