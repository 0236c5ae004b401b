"""Binary glTF file: a JSON description and the arrays that it refers to, in one buffer.

Source: Khronos, glTF 2.0 specification, 3.6 (buffers, accessors) and 4 (GLB).
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import __version__

MAGIC, VERSION = b"glTF", 2
JSON_CHUNK, BINARY_CHUNK = b"JSON", b"BIN\0"

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
"""What a view is for: vertices, and indices of vertices."""

_COMPONENTS = {"f4": 5126, "u4": 5125, "u2": 5123}
_SHAPES = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}


@dataclass(slots=True)
class BinaryFile:
    """A glTF asset while it is being written.

    Attributes:
        lists: top-level lists of the asset, such as "nodes", by name.
    """

    lists: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    _pieces: list[bytes] = field(default_factory=list)
    _length: int = 0

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Append an entry to a top-level list and return its index."""
        entries = self.lists.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def accessor(
        self, values: NDArray[np.generic], target: int | None = None, bounds: bool = False
    ) -> int:
        """Append an array and return the index of its accessor.

        Args:
            values: (n, ...) float32, uint32 or uint16; its other dimensions are those of one
                element. Matrices are given in rows and stored in columns.
            target: what it is for, None for animations and skins.
            bounds: whether the least and greatest elements are stored, as positions and times need.
        """
        if values.ndim == 3:
            values = values.transpose(0, 2, 1)
        data = np.ascontiguousarray(values).astype(values.dtype.newbyteorder("<")).tobytes()
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self._length, "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        # Every view begins at a multiple of four bytes.
        padded = data + bytes(-len(data) % 4)
        self._pieces.append(padded)
        self._length += len(padded)
        entry: dict[str, Any] = {
            "bufferView": self.add("bufferViews", view),
            "componentType": _COMPONENTS[values.dtype.str[1:]],
            "count": len(values),
            "type": _SHAPES[values.shape[1:]],
        }
        if bounds:
            least, greatest = values.min(axis=0), values.max(axis=0)
            entry["min"], entry["max"] = np.ravel(least).tolist(), np.ravel(greatest).tolist()
        return self.add("accessors", entry)

    def content(self, scene: dict[str, Any]) -> bytes:
        """Return the bytes of the file.

        Args:
            scene: the one scene of the asset.
        """
        whole = {
            "asset": {"version": "2.0", "generator": f"pronk {__version__}"},
            "scene": 0,
            "scenes": [scene],
            **self.lists,
            "buffers": [{"byteLength": self._length}],
        }
        text = json.dumps(whole, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        binary = b"".join(self._pieces)
        length = 12 + 8 + len(text) + 8 + len(binary)
        head = MAGIC + struct.pack("<II", VERSION, length)
        return b"".join([head, _chunk(JSON_CHUNK, text), _chunk(BINARY_CHUNK, binary)])


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + kind + data
