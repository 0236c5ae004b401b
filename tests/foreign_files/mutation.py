"""Mutated files: right files of every foreign format, made by code, and seeded damage to them."""

from __future__ import annotations

import io
import random
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

from tests.audio.soundfont_writer import sf2

EXTREMES = (0, 1, 2, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF)
"""Values that lengths and offsets are set to."""

ODD_WORDS = (b"-1", b"0", b"nan", b"1e999", b"99999999999999999999", "²".encode(), b"\xff\xfe", b"")
"""What numbers within text are replaced by."""


def soundfonts() -> list[bytes]:
    """Return SoundFonts of one preset and of several with a longer sample."""
    click = np.exp(-np.arange(400) / 90) * np.cos(np.arange(400))
    return [sf2(click), sf2(np.sin(np.arange(1000) / 9), [(0, 0), (0, 5), (128, 0)])]


def plys() -> list[bytes]:
    """Return a height grid as PLY of text and of both byte orders."""
    x, z = (a.ravel() for a in np.meshgrid(np.arange(4.0), np.arange(5.0)))
    vertices = np.stack([x, np.sin(x + z), z], axis=-1)
    found = []
    for order, kind in (("binary_little_endian", "<f4"), ("binary_big_endian", ">f4")):
        found.append(_ply_head(order, len(vertices)) + vertices.astype(kind).tobytes())
    rows = "".join(f"{a:.6g} {b:.6g} {c:.6g}\n" for a, b, c in vertices)
    return [*found, _ply_head("ascii", len(vertices)) + rows.encode()]


def _ply_head(order: str, count: int) -> bytes:
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    text = f"ply\nformat {order} 1.0\ncomment a grid\nelement vertex {count}\n{axes}"
    return f"{text}element face 0\nproperty list uchar int vertex_indices\nend_header\n".encode()


def objs() -> list[bytes]:
    """Return a height grid and a cube as OBJ."""
    grid = "".join(f"v {x} {0.1 * x * z:.3f} {z}\n" for z in range(5) for x in range(4))
    cube = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    return [f"# grid\no land\n{grid}f 1 2 5\n".encode(), f"{cube}f 1 2 3 4\n".encode()]


def hdrs() -> list[bytes]:
    """Return panoramas as HDR, run-length encoded and flat."""
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 8 +X 16\n"
    line = b"\x02\x02\x00\x10" + (b"\x90\x80" + b"\x04" + bytes(range(100, 104)) + b"\x8c\x90") * 2
    flat = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + bytes(range(120, 136)) * 2
    return [head + 8 * line, flat]


def exrs(folder: Path) -> list[bytes]:
    """Return panoramas as EXR of several compressions and kinds of pixels."""
    rng = np.random.default_rng(1)
    found = []
    for compression, kind in (
        (OpenEXR.NO_COMPRESSION, np.float32),
        (OpenEXR.ZIP_COMPRESSION, np.float16),
        (OpenEXR.PIZ_COMPRESSION, np.float16),
        (OpenEXR.RLE_COMPRESSION, np.float16),
        (OpenEXR.B44_COMPRESSION, np.float16),
    ):
        path = folder / "whole.exr"
        header = {"compression": compression, "type": OpenEXR.scanlineimage}
        pixels = rng.random((16, 32, 3)).astype(kind)
        with OpenEXR.File(header, {"RGB": pixels}) as file:
            file.write(str(path))
        found.append(path.read_bytes())
    return found


def pngs() -> list[bytes]:
    """Return height maps as PNG of 1, 8 and 16 bits, one of them with more chunks."""
    rows = (np.add.outer(np.arange(12), np.arange(9)) * 12).astype(np.uint8)
    pictures = [
        Image.fromarray(rows),
        Image.fromarray(rows.astype(np.uint16) * 257),
        Image.fromarray(rows).convert("1"),
    ]
    found = []
    for picture in pictures:
        stream = io.BytesIO()
        picture.save(stream, "PNG", dpi=(72, 72))
        found.append(stream.getvalue())
    return found


def formats(folder: Path) -> dict[str, list[bytes]]:
    """Return the right files of every format by its suffix."""
    return {
        ".sf2": soundfonts(),
        ".ply": plys(),
        ".obj": objs(),
        ".hdr": hdrs(),
        ".exr": exrs(folder),
        ".png": pngs(),
    }


def mutated(corpus: list[bytes], seed: int) -> bytes:
    """Return one of the files with one to four mutations, the same for the same seed."""
    rng = random.Random(seed)
    data = bytearray(rng.choice(corpus))
    for _ in range(rng.choice((1, 1, 2, 4))):
        if data:
            rng.choice(_MUTATIONS)(rng, data, rng.choice(corpus))
    # Behind a right frame damage gets deeper into the reader.
    return _reframed(bytes(data)) if rng.random() < 0.7 else bytes(data)


def _reframed(data: bytes) -> bytes:
    """Return a SoundFont with its size, a PNG with its sums, and other files as they are."""
    if data.startswith(b"RIFF"):
        return data[:4] + struct.pack("<I", max(len(data) - 8, 0)) + data[8:]
    if not data.startswith(b"\x89PNG"):
        return data
    pieces, at = [data[:8]], 8
    while at + 12 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        if at + 12 + length > len(data):
            break
        chunk = data[at + 4 : at + 8 + length]
        pieces.append(data[at : at + 4] + chunk + struct.pack(">I", zlib.crc32(chunk)))
        at += 12 + length
    return b"".join(pieces) + data[at:]


def _place(rng: random.Random, data: bytearray) -> int:
    """Return a place in the data, more often near its ends, where tables and headers are."""
    near = min(len(data), 400)
    if rng.random() < 0.3:
        return rng.randrange(len(data))
    return rng.randrange(near) if rng.random() < 0.4 else len(data) - 1 - rng.randrange(near)


def _flip_bits(rng: random.Random, data: bytearray, other: bytes) -> None:
    for _ in range(rng.choice((1, 1, 3, 16))):
        data[_place(rng, data)] ^= 1 << rng.randrange(8)


def _truncate(rng: random.Random, data: bytearray, other: bytes) -> None:
    del data[rng.randrange(len(data)) :]


def _splice(rng: random.Random, data: bytearray, other: bytes) -> None:
    start = rng.randrange(len(other))
    piece = other[start : start + rng.choice((1, 4, 20, 300))]
    at = _place(rng, data)
    data[at : at + rng.choice((0, len(piece)))] = piece


def _set_extreme(rng: random.Random, data: bytearray, other: bytes) -> None:
    """Set a length or an offset: of two, four or eight bytes, in either order."""
    width, order = rng.choice((2, 4, 4, 8)), rng.choice("<>")
    value = rng.choice(EXTREMES) & (2 ** (8 * width) - 1)
    packed = struct.pack(order + {2: "H", 4: "I", 8: "Q"}[width], value)
    at = _place(rng, data)
    data[at : at + width] = packed


def _replace_word(rng: random.Random, data: bytearray, other: bytes) -> None:
    """Replace a word of a text, or of what looks like one."""
    words = bytes(data).split(b" ")
    words[rng.randrange(len(words))] = rng.choice(ODD_WORDS)
    data[:] = b" ".join(words)


def _remove(rng: random.Random, data: bytearray, other: bytes) -> None:
    at = _place(rng, data)
    del data[at : at + rng.choice((1, 2, 4, 64))]


_MUTATIONS: tuple[Callable[[random.Random, bytearray, bytes], None], ...] = (
    _flip_bits,
    _flip_bits,
    _truncate,
    _splice,
    _set_extreme,
    _set_extreme,
    _replace_word,
    _remove,
)
