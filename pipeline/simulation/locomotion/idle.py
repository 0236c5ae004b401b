"""Idle motion: heads that keep level, tails and feelers that never quite rest.

The legs carry a creature; what else it has sways with its gait and wanders a little
of its own accord.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import Tree
from pipeline.simulation.figures.network import FEELER, HEAD, LEG, TAIL
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array

SWAY = {
    (HEAD, "yaw"): (0.05, 1.0),
    (HEAD, "roll"): (0.03, 1.0),
    (TAIL, "yaw"): (0.06, 1.0),
    (TAIL, "pitch"): (0.03, 2.0),
}
"""With the gait: amplitude [rad] and how many times a cycle."""

WANDER = {
    (HEAD, "yaw"): 0.05,
    (HEAD, "pitch"): 0.03,
    (FEELER, "yaw"): 0.20,
    (FEELER, "pitch"): 0.16,
    (FEELER, "bend"): 0.10,
}
"""Of its own accord: amplitude [rad]."""

LEVEL = {(HEAD, "pitch"): -0.6}
"""Part of the body's pitch that is taken back."""

SLOW, FAST = 0.25, 0.95
"""Range of the frequencies of wandering [1/s]."""


@dataclass(frozen=True, eq=False)
class Idlers:
    """The joints of a herd that carry nothing, as arrays (M,).

    Attributes:
        tree: these joints.
        owner: creature of each.
        names: such as "bug.head.base_yaw".
        number: its number in its own figure's skeleton.
    """

    tree: Tree
    owner: NDArray[np.int64]
    names: tuple[str, ...]
    number: NDArray[np.int64]
    lower: Array
    upper: Array
    preferred: Array
    sway: Array
    times: Array
    level: Array
    wander: Array
    frequency: Array
    offset: Array

    def values(self, phase: Array, pitch: Array, time: Array) -> Array:
        """Return the joint values (n, M) at n moments [rad].

        Args:
            phase: (n, C) of the creatures' gaits.
            pitch: (n, C) of the bodies, nose up [rad].
            time: (n,) since the start [s].
        """
        turns = 2.0 * np.pi
        q = self.preferred + self.level * pitch[:, self.owner]
        q = q + self.sway * np.sin(turns * self.times * phase[:, self.owner])
        # Two waves of incommensurable length never come round.
        angle = turns * self.frequency * time[:, None] + self.offset
        q = q + self.wander * (0.65 * np.sin(angle) + 0.35 * np.sin(1.618 * angle + 1.0))
        return np.clip(q, self.lower, self.upper)


def gather_idlers(names: Sequence[str], figures: Sequence[Figure], seed: int) -> Idlers:
    """Collect all joints that belong to no leg.

    Args:
        names: of the creatures; each draws its own chances.
        figures: of the creatures.
        seed: of the scene.
    """
    rows: list[tuple[int, int, int, str, str]] = []  # creature, joint, parent, kind, turn
    for c, figure in enumerate(figures):
        skeleton = figure.skeleton
        place = {}
        for limb in (limb for limb in skeleton.limbs if limb.kind != LEG):
            for j in limb.joints:
                parent = int(skeleton.parents[j])
                place[j] = len(rows)
                turn = skeleton.joint_names[j].rsplit("_", 1)[1]
                rows.append((c, j, place.get(parent, BODY), limb.kind, turn))
    skeletons = [figures[c].skeleton for c, *_ in rows]
    number = np.array([j for _, j, *_ in rows], dtype=np.int64)

    def taken(field: str, *shape: int) -> Array:
        values = [getattr(s, field)[j] for s, j in zip(skeletons, number, strict=True)]
        return np.array(values, dtype=float).reshape(len(rows), *shape)

    kinds = [(kind, turn) for *_, kind, turn in rows]
    chances = [
        generator(seed, f"{names[c]}.idle.{s.joint_names[j]}").random(2)
        for (c, j, *_), s in zip(rows, skeletons, strict=True)
    ]
    chance = np.array(chances).reshape(-1, 2)
    return Idlers(
        tree=Tree(
            np.array([parent for _, _, parent, *_ in rows], dtype=np.int64),
            taken("axes", 3),
            taken("places", 3),
            taken("prismatic").astype(bool),
        ),
        owner=np.array([c for c, *_ in rows], dtype=np.int64),
        names=tuple(
            f"{names[c]}.{s.joint_names[j]}" for (c, j, *_), s in zip(rows, skeletons, strict=True)
        ),
        number=number,
        lower=taken("lower"),
        upper=taken("upper"),
        preferred=taken("preferred"),
        sway=np.array([SWAY.get(k, (0.0, 1.0))[0] for k in kinds]),
        times=np.array([SWAY.get(k, (0.0, 1.0))[1] for k in kinds]),
        level=np.array([LEVEL.get(k, 0.0) for k in kinds]),
        wander=np.array([WANDER.get(k, 0.0) for k in kinds]),
        frequency=SLOW + (FAST - SLOW) * chance[:, 0],
        offset=2.0 * np.pi * chance[:, 1],
    )
