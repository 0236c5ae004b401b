"""Card: `golden.yaml`, what a golden is of, its limits, and digests of all its files.

The limits are meant to be edited. All else is sealed: a digest of the card without its limits
tells whether somebody wrote into it by hand, and digests of the files whether they are whole.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Final, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pipeline.errors import GoldenMissing, StoreError
from pipeline.production.goldens.frame_limits import Limits
from pipeline.production.goldens.verdict import Layer
from render.errors import FrameFileError
from render.image_files import read_png

FORMAT: Final = 1
_POINTER = b"version https://git-lfs"

_HEAD = """\
# A golden of pronk: what `pronk golden check` compares the scene {scene} with.
# The limits may be edited; all else belongs together and is written by pronk alone.
"""


class Framing(BaseModel):
    """Which frames a golden has, and how they are made."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    numbers: tuple[int, ...]
    size: tuple[int, int]
    samples: int


class Card(BaseModel):
    """What a golden is of.

    Attributes:
        golden: version of the layout.
        scene: its name.
        layers: that the golden has.
        limits: of its frames.
        calibrated: how many seeds the limits were proposed from, 0 for none.
        frames: which, and how they are made.
        environment: what pixels depend on, as `Backend.key` says it; empty without frames.
        files: name -> digest.
        seal: digest of all but the limits.
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
        """Return it with its seal."""
        return self.model_copy(update={"seal": self._digest()})

    @property
    def whole(self) -> bool:
        """Whether its seal is right."""
        return self.seal == self._digest()

    def _digest(self) -> str:
        words = self.model_dump(mode="json", exclude={"limits", "seal"})
        text = json.dumps(words, sort_keys=True)
        return hashlib.blake2b(text.encode(), digest_size=10).hexdigest()

    def encoded(self) -> str:
        """Return the text of its file."""
        words = self.model_dump(mode="json")
        text = yaml.safe_dump(words, sort_keys=False, allow_unicode=True, default_flow_style=None)
        return _HEAD.format(scene=self.scene) + text


def read_card(path: Path) -> Card:
    """Read a card.

    Raises:
        GoldenMissing: there is none.
        StoreError: it cannot be read, or something other than its limits was changed by hand.
    """
    try:
        words: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
        card = Card.model_validate(words)
    except FileNotFoundError:
        raise GoldenMissing(
            f"{path.parent}: there is no golden; write it with pronk golden record"
        ) from None
    except OSError as error:
        raise StoreError(f"{path}: could not be read: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the file"
        raise StoreError(f"{path}: {where}: {first['msg']}; {AGAIN}") from None
    except (ValueError, yaml.YAMLError) as error:
        why = str(error).splitlines()[0]
        raise StoreError(f"{path}: is no YAML, or cut short ({why}); {AGAIN}") from None
    if not card.whole:
        raise StoreError(
            f"{path}: something other than its limits was changed by hand (the seal {card.seal!r} "
            f"does not fit); {AGAIN}"
        )
    return card


AGAIN = "bring it back from version control, or write it anew with pronk golden record --again"


def file_digest(path: Path) -> str:
    """Return the digest of a golden's file: of a picture's pixels, or of a text's lines.

    Programs that pack pictures tighter and that write other ends of lines change neither.

    Raises:
        StoreError: it is missing or cannot be read.
    """
    try:
        data = path.read_bytes()
        if data.startswith(_POINTER):
            raise StoreError(f"{path}: is a pointer of Git LFS; fetch the file with git lfs pull")
        if path.suffix == ".png":
            pixels = read_png(path)
            data = repr(pixels.shape).encode() + pixels.tobytes()
        else:
            data = data.replace(b"\r\n", b"\n")
    except FileNotFoundError:
        raise StoreError(f"{path}: is missing from the golden; {AGAIN}") from None
    except OSError as error:
        raise StoreError(f"{path}: could not be read: {error.strerror}") from error
    except FrameFileError:
        raise StoreError(f"{path}: is no picture, or cut short; {AGAIN}") from None
    return hashlib.blake2b(data, digest_size=10).hexdigest()


def verify(card: Card, folder: Path, names: list[str]) -> None:
    """Make sure that files of a golden are those that the card was written with.

    Raises:
        StoreError: one is missing, damaged or changed.
    """
    for name in names:
        if file_digest(folder / name) != card.files.get(name):
            raise StoreError(
                f"{folder / name}: is not the file that the golden was written with; {AGAIN}"
            )
