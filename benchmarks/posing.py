"""Posing: time of a posed limb in a row of the take, and of the search for the poses of keys.

A person stands, and its right hand goes to places drawn from all that it can reach, relative to
its body, a second apart; beside it goes one whose hand stays at the first. Times are those of the
posed limb alone, by the row, with the search for the poses of keys and without: rows that follow
the poses of keys in a second run over the same limb. The ratio compares a row with the same limb's
own forward kinematics, measured side by side.

    python benchmarks/posing.py [keys]
"""

from __future__ import annotations

import os
import sys
import time

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_frames import FigureFrames
from pipeline.simulation.figures.figure_posture import FigurePosture
from pipeline.simulation.figures.kinematics import JointTree, LimbBatch
from pipeline.simulation.figures.pose_plan import plan_poses
from pipeline.spec import read_scene
from pipeline.spec.keyframes import PoseKey

ROW = 1 / 96
"""Time between two rows [s]."""

BLOCK = 96
"""Rows worked out together."""

RUNS = 3
"""Runs of each, in turn; the quickest counts."""


def seconds(posture: FigurePosture, count: int) -> tuple[float, float]:
    """Return processor time [s] of the posed values of `count` rows, and of their frames alone."""
    figure = posture.figure
    tree = JointTree.of(figure.skeleton)
    posed = plain = 0.0
    for first in range(0, count, BLOCK):
        times = np.arange(first, min(first + BLOCK, count), dtype=float) * ROW
        n = len(times)
        R, p = np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3))
        frames = FigureFrames(times, ROW, R, p + np.array([0.0, 1.0, 0.0]), R, p)
        q = np.tile(figure.skeleton.preferred, (n, 1))
        began = time.process_time()
        posture.values(q, frames)
        middle = time.process_time()
        # What a posture does beside its limbs: the frames, before and after.
        tree.pose(q)
        tree.pose(q)
        posed += middle - began
        plain += time.process_time() - middle
    return posed - plain, plain


def posture_of(figure: Figure, keys: int) -> FigurePosture:
    """Return the posture of a figure whose right hand goes to `keys` places."""
    limb = next(limb for limb in figure.skeleton.limbs if limb.name == "arm_r1")
    batch = LimbBatch.of([(figure.skeleton, limb)])
    share = np.random.default_rng(5).random((keys, batch.lower.shape[1]))
    places = batch.pose(batch.lower + share * (batch.upper - batch.lower)).tips
    plan = [
        PoseKey(at=float(k), limb="arm_r", frame="body", reach=tuple(place.tolist()))
        for k, place in enumerate(places)
    ]
    return FigurePosture(figure, plan_poses(plan, figure, "pose"), np.random.default_rng(1))


def main() -> None:
    """Measure and print."""
    keys = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    scene = read_scene("pronk: 1\nduration: 1\ncast:\n- {figure: person, name: p}\n")
    figure = build_figure("person", scene.figures["person"], 1.0)
    rows = round(keys / ROW)
    results = []
    for _ in range(RUNS):
        moving, still = posture_of(figure, keys), posture_of(figure, 1)
        first, plain = seconds(moving, rows)
        again, _ = seconds(moving, rows)
        held, _ = seconds(still, rows)
        results.append((first, again, held, plain))
    first, again, held, plain = (min(column) for column in zip(*results, strict=True))
    print(f"{keys} places, {rows} rows of a posed arm, {BLOCK} at once")
    print(f"  with the search for poses: {1e3 * first / rows:.3f} ms a row")
    print(f"  rows alone:                {1e3 * again / rows:.3f} ms a row")
    print(f"  at one place:              {1e3 * held / rows:.3f} ms a row")
    print(f"  rows alone take {again / plain:.1f} times the forward kinematics of the figure")


if __name__ == "__main__":
    main()
