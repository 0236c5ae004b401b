"""Part names: what an author calls limbs, nodes and joints of a figure.

A joint is called after the node that it stands at, with the unit of its value: elbow_r_deg
where there is one, hip_l_pitch_deg where there are several.
"""

from __future__ import annotations

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.point_goals import LimbPoint
from pipeline.simulation.spatial import normalized


class PartNames:
    """Names of limbs, nodes and joints.

    Attributes:
        figure: whose parts they are.
        limbs: name -> number of the limb.
        nodes: name -> limb, and which of its links ends there.
        joints: name -> limb, and which of its joints it is.
        body: names of the nodes of the body.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        skeleton, names = figure.skeleton, figure.drawing.names
        self.limbs = {limb.name: i for i, limb in enumerate(skeleton.limbs)}
        # A limb that is the only one of its side needs no number.
        for name, i in list(self.limbs.items()):
            short = name[:-1]
            if name.endswith("1") and len(short) > 1 and f"{short}2" not in self.limbs:
                self.limbs.setdefault(short, i)
        self.nodes: dict[str, tuple[int, int]] = {}
        self.joints: dict[str, tuple[int, int]] = {}
        for i, appendage in enumerate(figure.anatomy.appendages):
            for k, node in enumerate(appendage.nodes):
                if k:
                    self.nodes.setdefault(names[node], (i, k - 1))
                self._name_joints(i, k, names[node])
        self.body = {names[node] for node in figure.anatomy.body}

    def _name_joints(self, limb: int, k: int, node: str) -> None:
        """Name the joints of a limb that stand at its node number `k`."""
        skeleton = self.figure.skeleton
        start = "base_" if k == 0 else f"joint{k}_"
        here = [
            (column, joint, skeleton.joint_names[joint].rpartition(".")[2])
            for column, joint in enumerate(skeleton.limbs[limb].joints)
        ]
        here = [one for one in here if one[2].startswith(start)]
        for column, joint, name in here:
            unit = "" if skeleton.prismatic[joint] else "_deg"
            long = f"{node}_{name.removeprefix(start)}{unit}"
            self.joints.setdefault(long, (limb, column))
            if len(here) == 1:
                self.joints.setdefault(f"{node}{unit}", (limb, column))

    def point(self, limb: int, link: int) -> LimbPoint:
        """Return the node at the outer end of a limb's link."""
        skeleton = self.figure.skeleton
        own = skeleton.limbs[limb]
        there = skeleton.links[own.links[link]]
        column = own.joints.index(there.joint)
        return LimbPoint(column, there.ends[1], normalized(there.ends[1] - there.ends[0]))
