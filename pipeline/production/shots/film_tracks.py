"""Film tracks: what the shots of a film take from the whole take, not from the rows of a frame.

The path of a camera follows its subject over the whole cut, and a footprint stays for the rest of
the film. With these tracks a frame can be shot by whoever has only the rows of that frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import StoreError
from pipeline.production.camera.director.edit_decision import (
    EditDecision,
    decisions_json,
    decisions_of_json,
)
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.shots.footprint_timeline import FootprintTimeline
from render.development import Tone
from render.footprints import FootprintRaster
from render.shot import CameraPose, Lens

Arrays = dict[str, NDArray[Any]]

_POSE_NUMBERS = 12
"""Of a camera pose: two points, a direction, an angle, radius and focus of its lens."""


@dataclass(frozen=True, eq=False)
class FilmTracks:
    """Camera poses, footprints, exposures, clearings and grain of a film.

    Attributes:
        poses: of the camera, one for each frame.
        footprints: of the film, None without any.
        tones: exposure and contrast of each frame; empty before they are metered.
        clearings: where performers are, if anything is scattered over the ground.
        cuts: of the film, in the order of time.
        grain: (P,) least size of a pixel on each visible part [m]; empty where no coat grows and
            no bead stands.
    """

    poses: tuple[CameraPose, ...]
    footprints: FootprintTimeline | None
    tones: tuple[Tone, ...] = ()
    clearings: Clearings | None = None
    cuts: tuple[EditDecision, ...] = ()
    grain: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def arrays(self) -> Arrays:
        """Return the tracks as arrays: `poses` (F, 12), a pinhole with a NaN for its lens.

        `tones` (F, 3) are stops, contrasts and whites, `cuts` the bytes of JSON.
        """
        numbers = [
            (*pose.p_WC, *pose.p_WT, *pose.up, pose.fov_deg, *_lens_numbers(pose.lens))
            for pose in self.poses
        ]
        arrays: Arrays = {"poses": np.array(numbers, float).reshape(-1, _POSE_NUMBERS)}
        values = [(tone.stops, tone.contrast, tone.white) for tone in self.tones]
        arrays["cuts"] = np.frombuffer(decisions_json(self.cuts), np.uint8)
        arrays["tones"] = np.array(values, float).reshape(-1, 3)
        arrays["grain"] = self.grain
        if self.footprints is not None:
            raster = self.footprints.raster
            arrays["footprint_rows"] = self.footprints.rows
            arrays["footprint_grid"] = np.array([*raster.corner, raster.spacing])
            arrays["footprint_blocks"] = raster.blocks
            arrays["footprint_texels"] = raster.texels
        if self.clearings is not None:
            arrays.update(self.clearings.arrays())
        return arrays

    @staticmethod
    def of_arrays(arrays: Mapping[str, NDArray[Any]]) -> FilmTracks:
        """Return the tracks that `arrays` wrote.

        Raises:
            StoreError: one is missing, or has another shape.
        """
        try:
            poses = tuple(_pose(numbers) for numbers in arrays["poses"].tolist())
            tones = tuple(Tone(*pair) for pair in arrays["tones"].tolist())
            footprints = None
            if "footprint_rows" in arrays:
                x, z, spacing = arrays["footprint_grid"].tolist()
                blocks, texels = arrays["footprint_blocks"], arrays["footprint_texels"]
                raster = FootprintRaster((x, z), spacing, blocks, texels)
                footprints = FootprintTimeline(raster, arrays["footprint_rows"])
            clearings = Clearings.of_arrays(arrays)
            cuts = decisions_of_json(arrays["cuts"].tobytes())
            grain = arrays["grain"]
        except (KeyError, ValueError, TypeError) as error:
            raise StoreError(f"the tracks of the film cannot be read ({error!r})") from error
        return FilmTracks(poses, footprints, tones, clearings, cuts, grain)


def _lens_numbers(lens: Lens | None) -> tuple[float, float]:
    return (np.nan, np.nan) if lens is None else (lens.radius, lens.focus)


def _pose(numbers: list[float]) -> CameraPose:
    px, py, pz, tx, ty, tz, ux, uy, uz, fov_deg, radius, focus = numbers
    lens = None if np.isnan(radius) else Lens(radius, focus)
    return CameraPose((px, py, pz), (tx, ty, tz), (ux, uy, uz), fov_deg, lens)
