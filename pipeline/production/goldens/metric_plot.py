"""Metric plot: how far each frame of a golden is off, as a small drawing in a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pipeline.production.goldens.verdict import FrameVerdict, Outcome

_WIDTH: Final = 640
_HEIGHT: Final = 120
_LEFT: Final = 48
_BOTTOM: Final = 22


def metric_plot(frames: Sequence[FrameVerdict]) -> str:
    """Return FLIP of the worst tile and of the whole picture over the frames, as SVG."""
    first, last = frames[0].frame, frames[-1].frame
    top = max([0.05, *(frame.tile for frame in frames)])

    def place(frame: int, value: float) -> tuple[float, float]:
        x = _LEFT + (frame - first) / max(last - first, 1) * (_WIDTH - _LEFT - 12)
        return round(x, 1), round(8 + (1 - value / top) * (_HEIGHT - _BOTTOM - 8), 1)

    lines = []
    for name, values in (
        ("tile", [(f.frame, f.tile) for f in frames]),
        ("mean", [(f.frame, f.mean) for f in frames]),
    ):
        points = " ".join(f"{x},{y}" for x, y in (place(*value) for value in values))
        lines.append(f'<polyline class="{name}" points="{points}"/>')
    for frame in frames:
        x, y = place(frame.frame, frame.tile)
        fate = "fails" if frame.outcome is Outcome.CHANGED else "holds"
        lines.append(
            f'<circle class="{fate}" cx="{x}" cy="{y}" r="4"><title>frame {frame.frame}: '
            f"tile {frame.tile:.4f}, mean {frame.mean:.4f}</title></circle>"
            f'<text x="{x}" y="{_HEIGHT - 6}" text-anchor="middle">{frame.frame}</text>'
        )
    base = _HEIGHT - _BOTTOM
    return (
        f'<svg class="plot" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="FLIP over the frames">'
        f'<path class="axis" d="M{_LEFT} 8V{base}H{_WIDTH - 8}"/>'
        f'<text x="{_LEFT - 6}" y="14" text-anchor="end">{top:.2f}</text>'
        f'<text x="{_LEFT - 6}" y="{base}" text-anchor="end">0</text>'
        f"{''.join(lines)}"
        f'<text class="key" x="{_WIDTH - 8}" y="14" text-anchor="end">'
        f'<tspan class="tile">worst tile</tspan> <tspan class="mean">mean</tspan></text></svg>'
    )
