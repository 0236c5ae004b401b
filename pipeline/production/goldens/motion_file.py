"""Motion golden file: JSON whose diffs in version control can be read.

Rounded numbers and fingerprints are packed; contacts, sound events and notes are plain, one per
line.
"""

from __future__ import annotations

import json
import lzma
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import GoldenMissing, StoreError
from pipeline.production.goldens.motion_digest import Fingerprints
from pipeline.production.goldens.motion_golden import GroundSummary, MotionGolden
from pipeline.production.goldens.motion_marks import Mark
from pipeline.production.goldens.packed_series import Series

FORMAT = 1
"""Version of the file's layout."""

UNREADABLE = (ValueError, KeyError, TypeError, AttributeError, lzma.LZMAError, EOFError)


def write_golden(golden: MotionGolden, path: Path) -> None:
    """Write `golden` to `path` atomically.

    Raises:
        StoreError: it cannot be written.
    """
    try:
        make_folder(path.parent)
        write_if_changed(path, encoded(golden).encode())
    except OSError as error:
        raise StoreError(f"{path}: the golden could not be written: {error.strerror}") from error


def read_golden(path: Path) -> MotionGolden:
    """Read the golden in `path`.

    Raises:
        GoldenMissing: it does not exist.
        StoreError: it cannot be read, is damaged, or has an unknown format.
    """
    try:
        members = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise GoldenMissing(f"{path}: there is no such golden") from None
    except OSError as error:
        raise StoreError(f"{path}: the golden could not be read: {error.strerror}") from error
    except ValueError as error:
        raise StoreError(f"{path}: is no golden, or cut short ({error}); write it anew") from None
    kind = members.get("motion golden") if isinstance(members, dict) else None
    if kind is None:
        raise StoreError(f"{path}: is no golden of a motion")
    if kind != FORMAT:
        raise StoreError(
            f"{path}: is a golden of format {kind!r}, where {FORMAT} can be read; write it anew"
        )
    try:
        return _decoded(members)
    except UNREADABLE as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); write it anew") from None


def encoded(golden: MotionGolden) -> str:
    """Return the text of `golden`'s file."""
    members: dict[str, Any] = {
        "motion golden": FORMAT,
        **{f.name: getattr(golden, f.name) for f in fields(golden)},
        "series": {name: series.packed() for name, series in golden.series.items()},
        "fingerprints": golden.fingerprints.packed(),
        "marks": [[getattr(mark, f.name) for f in fields(Mark)] for mark in golden.marks],
        "land": asdict(golden.land),
    }
    if golden.predictable is None:
        del members["predictable"]
    body = ",\n".join(f"{_line(key)}: {_block(value)}" for key, value in members.items())
    return f"{{\n{body}\n}}\n"


def _block(value: Any) -> str:
    """Return a list or a nested mapping with one item per line."""
    if isinstance(value, list) and value:
        return "[\n" + ",\n".join(f"  {_line(item)}" for item in value) + "\n]"
    if isinstance(value, dict) and any(isinstance(item, dict) for item in value.values()):
        items = (f"  {_line(key)}: {_line(item)}" for key, item in value.items())
        return "{\n" + ",\n".join(items) + "\n}"
    return _line(value)


def _line(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def _decoded(members: dict[str, Any]) -> MotionGolden:
    golden = MotionGolden(
        **{
            **{f.name: members[f.name] for f in fields(MotionGolden) if f.name != "predictable"},
            "nodes": tuple(members["nodes"]),
            "series": {name: Series.unpacked(s) for name, s in members["series"].items()},
            "fingerprints": Fingerprints.unpacked(members["fingerprints"]),
            "marks": tuple(
                Mark(kind, who, what, moment, frame, tuple(place), strength)
                for kind, who, what, moment, frame, place, strength in members["marks"]
            ),
            "land": GroundSummary(**{**members["land"], "cells": tuple(members["land"]["cells"])}),
            "predictable": members.get("predictable"),
        }
    )
    _check(golden)
    return golden


def _check(golden: MotionGolden) -> None:
    """Refuse numbers that do not fit the names."""
    J, C = len(golden.nodes), len(golden.channels)
    widths = {"positions": 3 * J, "rotations": 4 * J, "alive": J, "scales": 3 * J}
    for name, width in {**widths, "values": C, "terrain": 3}.items():
        found = golden.series[name].multiples.shape[1]
        if found != width:
            raise ValueError(f"{name} has {found} columns where {width} belong")
    prints = golden.fingerprints
    rows = golden.facts["frames"] * golden.facts["samples"] + 1
    if (len(prints.rows), len(prints.tracks)) != (rows, J + C):
        raise ValueError("the fingerprints do not fit the rows and names")
