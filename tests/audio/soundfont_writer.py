"""A small SoundFont, written from its parts: one sample under every key of some programs."""

from __future__ import annotations

import struct
from collections.abc import Iterable

import numpy as np

SAMPLE_RATE = 48_000
ROOT = 60
"""Key at which the sample is played as it is."""


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def _list(name: bytes, *chunks: bytes) -> bytes:
    return _chunk(b"LIST", name + b"".join(chunks))


def _named(name: str) -> bytes:
    return name.encode("ascii")[:19].ljust(20, b"\0")


def sf2(sample: np.ndarray, presets: Iterable[tuple[int, int]] = ((0, 0),)) -> bytes:
    """Return a SoundFont.

    Args:
        sample: (N,) within -1 to 1, at 48 kHz.
        presets: (bank, program) of each.
    """
    pcm = np.rint(np.clip(sample, -1, 1) * 32767).astype("<i2").tobytes() + b"\0" * 92
    presets = sorted(presets)
    heads = b""
    for i, (bank, program) in enumerate([*presets, (0, 0)]):
        heads += _named(f"P{i}" if i < len(presets) else "EOP")
        heads += struct.pack("<HHHIII", program, bank, i, 0, 0, 0)
    generators = b"".join(struct.pack("<HH", 41, 0) for _ in presets) + struct.pack("<HH", 0, 0)
    bags = b"".join(struct.pack("<HH", i, 0) for i in range(len(presets) + 1))
    header = _named("S") + struct.pack(
        "<IIIIIBbHH", 0, sample.size, 0, sample.size, SAMPLE_RATE, ROOT, 0, 0, 1
    )
    end = _named("EOS") + struct.pack("<IIIIIBbHH", 0, 0, 0, 0, 0, 0, 0, 0, 0)
    data = _list(
        b"pdta",
        _chunk(b"phdr", heads),
        _chunk(b"pbag", bags),
        _chunk(b"pmod", bytes(10)),
        _chunk(b"pgen", generators),
        _chunk(b"inst", _named("I") + struct.pack("<H", 0) + _named("EOI") + struct.pack("<H", 1)),
        _chunk(b"ibag", struct.pack("<HHHH", 0, 0, 1, 0)),
        _chunk(b"imod", bytes(10)),
        _chunk(b"igen", struct.pack("<HHHH", 53, 0, 0, 0)),
        _chunk(b"shdr", header + end),
    )
    info = _list(b"INFO", _chunk(b"ifil", struct.pack("<HH", 2, 1)), _chunk(b"INAM", b"test\0\0"))
    body = b"sfbk" + info + _list(b"sdta", _chunk(b"smpl", pcm)) + data
    return b"RIFF" + struct.pack("<I", len(body)) + body
