"""Heights from a grayscale picture."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.from_file import refused
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain import ImageTerrain

MOST, FEWEST = 4000, 3
"""Pixels along one side."""

WHITE = {"1": 1.0, "L": 255.0, "I;16": 65535.0, "I;16B": 65535.0, "I": 65535.0}
"""Value of white by Pillow's name of the kind of picture."""


def image(words: ImageTerrain, chance: np.random.Generator) -> HeightField:
    """Return the heights of a picture: a vertex a pixel, or as many cells as are asked.

    The picture lies as it is seen from above with x to the right: its first row is at the
    lowest z.

    Raises:
        SceneError: the file is no such picture.
    """
    del chance
    field = HeightField(words.low + (words.high - words.low) * read_gray(words.file), words.size)
    if words.cells is None or words.cells == field.cells:
        return field
    n_x, n_z = words.cells
    x = np.linspace(-field.size[0] / 2.0, field.size[0] / 2.0, n_x + 1)
    z = np.linspace(-field.size[1] / 2.0, field.size[1] / 2.0, n_z + 1)
    return HeightField(field.height(*np.meshgrid(x, z)), words.size)


def read_gray(file: str) -> Array:
    """Return a grayscale picture (height, width) of values 0 to 1.

    Raises:
        SceneError: the file is no such picture.
    """
    name = f"'{Path(file).name}'"
    try:
        with warnings.catch_warnings():
            # Of pictures beyond 89 million pixels Pillow warns before it tells their size.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(file, formats=("PNG",))
        with picture:
            _check(picture, name)
            values = np.asarray(picture, dtype=float)
            return values / WHITE[picture.mode]
    except UnidentifiedImageError:
        raise refused(f"{name} is no PNG picture") from None
    except Image.DecompressionBombError:
        raise refused(f"{name} is larger than {MOST} x {MOST} pixels") from None
    except (OSError, SyntaxError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise refused(f"{name} cannot be read: {reason}") from None


def _check(picture: Image.Image, name: str) -> None:
    width, height = picture.size
    if max(width, height) > MOST:
        told = f"{width} x {height} pixels, more than {MOST} x {MOST}"
        raise refused(f"{name} has {told}; make it smaller")
    if min(width, height) < FEWEST:
        raise refused(f"{name} has {width} x {height} pixels, fewer than {FEWEST} x {FEWEST}")
    if picture.mode not in WHITE:
        raise refused(
            f"{name} is a picture of kind {picture.mode}; should be grayscale of 8 or 16 bits"
        )
