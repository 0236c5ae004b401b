"""Golden card: `golden.yaml`, with the limits of a golden and the digests of its files.

Only the limits are meant to be edited. A seal, the digest of the card without its limits, reveals
other edits; the digests of the files reveal damage.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Final, Literal

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pipeline.errors import GoldenMissing, StoreError
from pipeline.production.goldens.verdict import Layer
from render.comparison.flip_metric import flip
from render.comparison.image_statistics import (
    exposure_change,
    region_deviation,
    seed_spread,
    tile_deviations,
    tile_means,
)
from render.errors import FrameFileError
from render.image_files import read_png

SAFETY_FACTOR: Final = 1.25
"""Ratio of the limits to the largest differences between seeds."""

_MIN_MEAN, _MIN_TILE = 0.002, 0.01

# Few seeds underestimate some variances: noise alone reached 5.1.
_MIN_Z = 8.0

# Noise alone reached 0.007 stops in pictures of 96 x 54 pixels and 64 samples.
_MIN_EXPOSURE = 0.02

# The largest of a few differences of either sign: others are more often beyond it than FLIP's.
_EXPOSURE_FACTOR = 2.0


class Limits(BaseModel):
    """Limits of the difference of a frame from its golden; the editable part of a golden.

    The defaults suit most frames; calibration measures their noise.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    mean: float = Field(0.03, gt=0, le=1, description="FLIP over a picture.")
    tile: float = Field(0.15, gt=0, le=1, description="FLIP over its worst tile.")
    z: float = Field(
        8.0, gt=0, le=1000, description="Deviations of the mean of its worst tile or region."
    )
    exposure: float = Field(
        _MIN_EXPOSURE, gt=0, le=20, description="Change of its mean luminance [stops]."
    )


@dataclass(frozen=True, slots=True)
class NoiseLevel:
    """Largest differences between pictures that differ by noise alone.

    Attributes:
        count: number of pictures of each frame.
        mean: FLIP over a picture.
        tile: FLIP over a tile.
        z: deviations of a tile or a region, of each picture from all others.
        exposure: change of the mean luminance [stops].
    """

    count: int
    mean: float
    tile: float
    z: float
    exposure: float

    def limits(self) -> Limits:
        """Return the limits for this noise."""
        return Limits(
            mean=round(min(max(self.mean * SAFETY_FACTOR, _MIN_MEAN), 1.0), 4),
            tile=round(min(max(self.tile * SAFETY_FACTOR, _MIN_TILE), 1.0), 4),
            z=round(max(self.z * SAFETY_FACTOR, _MIN_Z), 2),
            exposure=round(max(self.exposure * _EXPOSURE_FACTOR, _MIN_EXPOSURE), 3),
        )


def noise_level(frames: Sequence[Sequence[NDArray[np.uint8]]]) -> NoiseLevel:
    """Return the noise level of frames.

    Args:
        frames: at least three pictures of each frame, made with different seeds.
    """
    means, tiles, zs, exposures = [], [], [], []
    for pictures in frames:
        for one, two in combinations(pictures, 2):
            errors = flip(one, two)
            means.append(float(errors.mean()))
            tiles.append(float(tile_means(errors).max()))
            exposures.append(abs(exposure_change(one, two)))
        for k, picture in enumerate(pictures):
            others = seed_spread([*pictures[:k], *pictures[k + 1 :]])
            zs.append(float(tile_deviations(others, picture).max()))
            zs.append(region_deviation(others, picture))
    return NoiseLevel(len(frames[0]), max(means), max(tiles), max(zs), max(exposures))


FORMAT: Final = 1
_LFS_POINTER = b"version https://git-lfs"

_HEAD = """\
# A golden of pronk: what `pronk golden check` compares the scene {scene} with.
# The limits may be edited; all else belongs together and is written by pronk alone.
"""


class Framing(BaseModel):
    """Frames of a golden and their rendering."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    numbers: tuple[int, ...]
    size: tuple[int, int]
    samples: int


class Card(BaseModel):
    """Contents of `golden.yaml`.

    Attributes:
        golden: version of the layout.
        scene: name of the scene.
        layers: of the golden.
        limits: of its frames.
        calibrated: number of seeds that the limits come from, 0 for none.
        frames: numbers, size and samples.
        environment: `Backend.key`, which pixels depend on; empty without frames.
        files: name -> digest.
        seal: digest of everything but the limits.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    golden: Literal[1] = FORMAT
    scene: str
    layers: tuple[Layer, ...] = Field(min_length=1)
    limits: Limits = Limits()
    calibrated: int = 0
    frames: Framing | None = None
    environment: str = ""
    files: dict[str, str]
    seal: str = ""

    def sealed(self) -> Card:
        """Return the card with its seal."""
        return self.model_copy(update={"seal": self._digest()})

    @property
    def is_sealed(self) -> bool:
        """Whether the seal is right."""
        return self.seal == self._digest()

    def _digest(self) -> str:
        members = self.model_dump(mode="json", exclude={"limits", "seal"})
        text = json.dumps(members, sort_keys=True)
        return hashlib.blake2b(text.encode(), digest_size=10).hexdigest()

    def encoded(self) -> str:
        """Return the text of its file."""
        members = self.model_dump(mode="json")
        text = yaml.safe_dump(members, sort_keys=False, allow_unicode=True, default_flow_style=None)
        return _HEAD.format(scene=self.scene) + text


def read_card(path: Path) -> Card:
    """Read a card.

    Raises:
        GoldenMissing: it does not exist.
        StoreError: it cannot be read, or more than its limits was edited.
    """
    try:
        card = Card.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise GoldenMissing(
            f"{path.parent}: there is no golden; write it with pronk golden record"
        ) from None
    except OSError as error:
        raise StoreError(f"{path}: could not be read: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the file"
        raise StoreError(f"{path}: {where}: {first['msg']}; {RESTORE_HINT}") from None
    except (ValueError, yaml.YAMLError) as error:
        why = str(error).splitlines()[0]
        raise StoreError(f"{path}: is no YAML, or cut short ({why}); {RESTORE_HINT}") from None
    if not card.is_sealed:
        raise StoreError(
            f"{path}: something other than its limits was changed by hand (the seal {card.seal!r} "
            f"does not fit); {RESTORE_HINT}"
        )
    return card


RESTORE_HINT = (
    "bring it back from version control, or write it anew with pronk golden record --again"
)


def file_digest(path: Path) -> str:
    """Return the digest of a golden's file: of the pixels of a picture, or the lines of a text.

    Repacking a picture or other ends of lines do not change it.

    Raises:
        StoreError: it is missing or unreadable.
    """
    try:
        data = path.read_bytes()
        if data.startswith(_LFS_POINTER):
            raise StoreError(f"{path}: is a pointer of Git LFS; fetch the file with git lfs pull")
        if path.suffix == ".png":
            pixels = read_png(path)
            data = repr(pixels.shape).encode() + pixels.tobytes()
        else:
            data = data.replace(b"\r\n", b"\n")
    except FileNotFoundError:
        raise StoreError(f"{path}: is missing from the golden; {RESTORE_HINT}") from None
    except OSError as error:
        raise StoreError(f"{path}: could not be read: {error.strerror}") from error
    except FrameFileError:
        raise StoreError(f"{path}: is no picture, or cut short; {RESTORE_HINT}") from None
    return hashlib.blake2b(data, digest_size=10).hexdigest()


def verify(card: Card, folder: Path, names: list[str]) -> None:
    """Check files of a golden against the digests of its card.

    Raises:
        StoreError: a file is missing, damaged or changed.
    """
    for name in names:
        if file_digest(folder / name) != card.files.get(name):
            raise StoreError(
                f"{folder / name}: is not the file that the golden was written with; {RESTORE_HINT}"
            )
