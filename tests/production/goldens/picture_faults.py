"""Faults of the picture: of light, camera and materials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.production.goldens.cue_facts import Cues
from tests.production.goldens.golden_bases import Picture
from tests.production.goldens.golden_faults import cues, moved, picture, word

# --- light ------------------------------------------------------------------------


def brighter(factors: Any) -> Callable[[Picture], Picture]:
    """Return a gain of linear light, one for each primary."""

    def alter(p: Picture) -> Picture:
        return np.clip(np.rint(255 * ((p / 255) ** 2.2 * factors) ** (1 / 2.2)), 0, 255).astype(
            np.uint8
        )

    return alter


def patch(rows: slice, columns: slice, alter: Callable[[Picture], Picture]) -> Any:
    """Return an alteration of a part of a picture."""

    def within(p: Picture) -> Picture:
        out = p.copy()
        out[rows, columns] = alter(p[rows, columns])
        return out

    return within


LIGHT = (
    word("exposure 0.03 stops up", "frames", "depth: 3", "depth: 3, exposure: 0.03", "brighter"),
    word("exposure 0.03 stops down", "frames", "depth: 3", "depth: 3, exposure: -0.03", "darker"),
    word(
        "exposure 0.001 stops up",
        "motion",
        "depth: 3",
        "depth: 3, exposure: 0.001",
        "film: exposure",
    ),
    picture("light 2 % stronger", brighter(1.021), "stops brighter"),
    picture("red light 4 % stronger", brighter([1.04, 1.0, 1.0])),
    picture("a third of the picture 4 % darker", patch(slice(None), slice(32), brighter(0.96))),
    picture("a spot ten levels darker", patch(slice(16, 32), slice(48, 64), lambda p: p - 10)),
    word("rim light off", "frames", "rim: 0.5", "rim: 0.0"),
    word(
        "rim light a tenth weaker", "motion", "rim: 0.5", "rim: 0.45", "light: studio.rim is 0.45"
    ),
    word("key light from 10 degrees further", "frames", "fill: 0.3", "fill: 0.3, heading_deg: -40"),
    word("fill light off", "frames", "fill: 0.3", "fill: 0.0"),
    word("the sun half an hour later", "frames", "hour: 16.5", "hour: 17", base=1),
    word("the sun a minute later", "motion", "hour: 16.5", "hour: 16.517", "light: sun.hour", 1),
    word("clouds", "frames", "hour: 16.5", "hour: 16.5, clouds: 0.2", base=1),
    word(
        "a lamp",
        "frames",
        "rim: 0.5}",
        "rim: 0.5}, lamps: [{at: [0.5, 0.8, 0.5], brightness: 0.5, radius: 0}]",
    ),
    word("haze", "frames", "hour: 16.5", "hour: 16.5, turbidity: 6", base=1),
)

# --- camera -----------------------------------------------------------------------


def pose_of(frame: int, number: int, by: float) -> Callable[[Cues], Cues]:
    """Return a change of one number of the camera in one frame."""

    def alter(found: Cues) -> Cues:
        pose = list(found.camera[frame])
        pose[number] += by
        return replace(found, camera={**found.camera, frame: tuple(pose)})

    return alter


CAMERA = (
    word("camera a centimetre higher", "motion", "0.5, 0.9]", "0.51, 0.9]", "from frame 1 on"),
    word("camera a centimetre higher, by pictures", "frames", "0.5, 0.9]", "0.51, 0.9]"),
    word(
        "camera looks a centimetre aside", "motion", "[0.1, 0.12", "[0.11, 0.12", "looks otherwise"
    ),
    word(
        "field of view of 35.1 degrees", "motion", "0.12, 0]", "0.12, 0], fov_deg: 35.1", "degrees"
    ),
    word("field of view of 36 degrees", "frames", "0.12, 0]", "0.12, 0], fov_deg: 36"),
    word("lens instead of a pinhole", "motion", "0.12, 0]", "0.12, 0], aperture: 4", "opens"),
    word(
        "camera moves", "motion", "0.12, 0]", "0.12, 0], velocity: [0.1, 0, 0]", "from frame 2 on"
    ),
    word("camera follows", "motion", "look_at: [0.1, 0.12, 0]", "follow: bug"),
    word(
        "a cut too many",
        "motion",
        "{at: [0.9, 0.5, 0.9], look_at: [0.1, 0.12, 0]}",
        "[{at: [0.9, 0.5, 0.9], look_at: [0.1, 0.12, 0]}, {start: 0.25, follow: ball}]",
        "from frame 7 on",
    ),
    cues("one pose 3 mm off", pose_of(5, 2, 0.003), "from frame 5 on, by 0.003 m"),
    cues("one pose tilted", pose_of(12, 6, 0.01), "is turned otherwise from frame 12 on"),
    picture("mirrored picture", lambda p: p[:, ::-1]),
    picture("picture shifted by a pixel", lambda p: np.roll(p, 1, axis=1)),
)

# --- materials --------------------------------------------------------------------

GROUND, RUBBER = "{preset: dry soil}", "{preset: red rubber, roughness: 0.4}"

MATERIALS = (
    moved(
        "a limb of another material",
        lambda t: {"parts": (*t.parts[:3], replace(t.parts[3], material="steel"), *t.parts[4:])},
        "is of steel",
    ),
    word("ground of sand", "frames", GROUND, "{preset: sand}"),
    word("ground of damp soil", "frames", GROUND, "{preset: dry soil, color: '#7a6048'}"),
    word(
        "colour a step off",
        "motion",
        RUBBER,
        "{preset: red rubber, roughness: 0.4, color: '#a8201a'}",
    ),
    word(
        "rougher rubber",
        "motion",
        "roughness: 0.4",
        "roughness: 0.42",
        "material rubber: roughness",
    ),
    word("metallic rubber", "frames", "roughness: 0.4", "roughness: 0.4, metallic: 1"),
    word("glowing rubber", "frames", "roughness: 0.4", "roughness: 0.4, glow: 0.3"),
    word("blue rubber", "frames", "red rubber", "blue plastic"),
    word("coarser soil", "motion", GROUND, "{preset: dry soil, texture_scale: 3}", "texture_scale"),
    word("flat soil", "motion", GROUND, "{preset: dry soil, bump: 0}", "bump"),
    word("soil without a pattern", "frames", GROUND, "{preset: dry soil, texture: none}"),
    word("ball of another material", "motion", "material: rubber", "material: clay", again=True),
)
