"""Pose interpolator: the camera between two frames, while the shutter is open."""

from __future__ import annotations

from collections.abc import Sequence

from render.shot import CameraPose, Lens

Triple = tuple[float, float, float]


class PoseInterpolator:
    """Interpolates camera poses linearly between the frames of a cut.

    Args:
        poses: by frame.
        cuts: first frame of each cut.
    """

    def __init__(self, poses: Sequence[CameraPose], cuts: Sequence[int]) -> None:
        self._poses, self._cuts = poses, frozenset(cuts)

    def at(self, frame: int, part: float) -> CameraPose:
        """Return the pose a fraction of a frame after the start of the 1-based `frame`."""
        now = self._poses[frame - 1]
        if part == 0.0:
            return now
        if self._continues(frame):
            return _between(now, self._poses[frame], part)
        # The last frame of a cut extrapolates the motion before it.
        if frame > 1 and self._continues(frame - 1):
            return _between(self._poses[frame - 2], now, 1.0 + part)
        return now

    def _continues(self, frame: int) -> bool:
        """Return whether the next frame after a 1-based `frame` belongs to the same cut."""
        return frame < len(self._poses) and frame + 1 not in self._cuts


def _between(a: CameraPose, b: CameraPose, part: float) -> CameraPose:
    if a == b:
        return a
    return CameraPose(
        p_WC=_mixed(a.p_WC, b.p_WC, part),
        p_WT=_mixed(a.p_WT, b.p_WT, part),
        up=_mixed(a.up, b.up, part),
        fov_deg=a.fov_deg + part * (b.fov_deg - a.fov_deg),
        lens=_between_lenses(a.lens, b.lens, part),
    )


def _between_lenses(a: Lens | None, b: Lens | None, part: float) -> Lens | None:
    if a is None or b is None:
        return a
    # Extrapolated values must stay positive.
    radius = max(a.radius + part * (b.radius - a.radius), 0.5 * b.radius)
    focus = max(a.focus + part * (b.focus - a.focus), 0.5 * b.focus)
    return Lens(radius, focus)


def _mixed(a: Triple, b: Triple, part: float) -> Triple:
    x, y, z = (p + part * (q - p) for p, q in zip(a, b, strict=True))
    return x, y, z
