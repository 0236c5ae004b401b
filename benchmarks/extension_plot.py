"""Full extension: a leg's joints while its tip is led out beyond its reach and back.

Draws the joint values over time, by the method for full extension and by the plain
pseudo-inverse, as an SVG.

    python benchmarks/extension_plot.py [file.svg]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from pipeline.simulation.figures.ball_joint_ik import full_reach
from pipeline.simulation.figures.figure import build_figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.reach_ik import reach
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene

STEPS = 400
BEYOND = 1.03
"""Farthest goal, as a part of the greatest distance from base to tip."""

WIDTH, HEIGHT = 720, 220
SHOWN = np.pi
"""Joint values beyond this are cut off [rad]."""

COLORS = ("#3b6ea5", "#c0504d", "#6aa84f", "#8064a2", "#d98c1f")


def follow(leg: LimbBatch, plain: bool) -> tuple[Array, Array]:
    """Return joint values (STEPS, n), and distances of the tip from where it can be (STEPS,)."""
    start, base = leg.pose(leg.preferred), leg.places[:, 0]
    near = np.linalg.norm(start.tips - base, axis=-1)
    away, most = (start.tips - base) / near[:, None], full_reach(leg)
    pose, values, off = start, [], []
    for t in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
        asked = near + (BEYOND * most - near) * (1.0 - abs(2.0 * t - 1.0))
        goal = base + away * asked[:, None]
        if plain:
            plus = np.linalg.pinv(pose.jacobian.transpose(0, 2, 1))
            pose = leg.pose(pose.q + (plus @ (goal - pose.tips)[..., None])[..., 0])
        else:
            pose = reach(leg, pose, goal).pose
        there = base + away * np.minimum(asked, most)[:, None]
        values.append(pose.q[0])
        off.append(np.linalg.norm(pose.tips - there) / leg.lengths[0])
    return np.array(values), np.array(off)


def panel(title: str, values: Array, top: float) -> str:
    """Return one diagram, a line a joint."""
    x = np.linspace(0.0, WIDTH, len(values))
    y = top + HEIGHT / 2.0 * (1.0 - np.clip(values, -SHOWN, SHOWN) / SHOWN)
    lines = [
        f'<text x="4" y="{top + 14:.0f}" font-family="sans-serif" font-size="13">{title}</text>',
        f'<rect x="0" y="{top}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
    ]
    for k, color in enumerate(COLORS[: values.shape[1]]):
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y[:, k], strict=True))
        lines.append(f'<polyline points="{points}" fill="none" stroke="{color}"/>')
    return "\n".join(lines)


def main(path: Path) -> None:
    """Draw, and print the greatest movement of a joint in one step."""
    scene = read_scene("pronk: 1\nduration: 1\ncast: [{figure: beetle}]\n")
    skeleton = build_figure("beetle", scene.figures["beetle"], 1.0).skeleton
    leg = LimbBatch.of([(skeleton, skeleton.legs[0])])
    panels = []
    for row, (title, plain) in enumerate(
        [("full extension by binary search", False), ("plain pseudo-inverse", True)]
    ):
        values, off = follow(leg, plain)
        most = np.abs(np.diff(values, axis=0)).max()
        print(f"{title}: at most {most:.3g} rad a step, tip off by {off.max():.2g} of the length")
        panels.append(panel(title, values, row * (HEIGHT + 20.0)))
    size = f'width="{WIDTH}" height="{2 * HEIGHT + 20}"'
    body = "\n".join(panels)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n'
        f'<rect width="100%" height="100%" fill="white"/>\n{body}\n</svg>\n'
    )
    print(f"wrote {path}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "extension.svg"))
