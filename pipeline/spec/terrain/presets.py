"""Presets of terrains: names that stand for a kind and some of its words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

TERRAIN_PRESETS: Mapping[str, Mapping[str, Any]] = {
    "flat": {"kind": "flat"},
    "fractal": {"kind": "fractal"},
    "hills": {"kind": "hills"},
    "meadow": {"kind": "hills", "height": 0.5, "spacing": 7.0, "material": "grass"},
    "dunes": {"kind": "hills", "height": 2.2, "spacing": 9.0, "material": "sand"},
    "rocks": {"kind": "fractal", "height": 1.6, "roughness": 0.6, "material": "rock"},
    "stairs": {"kind": "stairs", "material": "grey plaster"},
    "ramp": {"kind": "ramp"},
    "ditches": {"kind": "ditches"},
    "stones": {"kind": "stones", "material": "rock"},
    "boulders": {"kind": "boulders"},
}
