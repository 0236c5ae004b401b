"""Contact coupling: a troupe that collides with the solids of other troupes, one step later.

Obstacles are read in the row before, with their velocities there, and extrapolated within the
step. The colliding troupe applies the impulses on obstacles that give way; the troupe that owns
them integrates these until the next row.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.attachment import Attachment, split_attachments
from pipeline.simulation.dynamics.kinematic_bodies import KinematicBodies, Poses
from pipeline.simulation.obstacles import Obstacle, SolidMotion
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.spatial import matrix, turn
from pipeline.simulation.troupe import Troupe, node_range, pushed_troupe
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.prop import Prop
from pipeline.spec.scene import Scene


class ContactCoupling:
    """One colliding troupe and its obstacles.

    Args:
        troupe: the troupe that collides.
        recorder: the take under construction.
        fixed: solids that move as their troupes say and are not pushed.
        movable: solids of `owner`, which are.
        owner: the troupe that is pushed, None if `movable` is empty.
        still: whether no obstacle ever moves, so that one update is enough.
    """

    def __init__(
        self,
        troupe: Troupe,
        recorder: Recorder,
        fixed: Sequence[Obstacle],
        movable: Sequence[Obstacle],
        owner: Troupe | None,
        still: bool,
    ) -> None:
        self.still = still
        self.troupe, self.recorder, self.owner = troupe, recorder, owner
        taken = {id(solid) for solid in troupe.set_obstacles([*fixed, *movable])}
        self.nodes = np.array([s.node for s in fixed if id(s) in taken], dtype=np.int64)
        # Which of the movable ones are obstacles; they come after the fixed ones.
        self._movable = np.array([id(solid) in taken for solid in movable], dtype=bool)
        clock = recorder.clock
        row = clock.dt * (clock.steps // clock.samples)
        self._motion = KinematicBodies(len(self.nodes), row)
        self._row = -1

    def update(self, row: int) -> None:
        """Passes pose and velocity of all obstacles in a written row to the colliding troupe."""
        if row == self._row or (self.still and self._row >= 0):
            return
        first, self._row = self._row < 0, row
        recorder, nodes = self.recorder, self.nodes
        if self.owner is not None and not len(nodes):
            self.troupe.update_obstacles(self.owner.solid_motion().selected(self._movable))
            return
        here = Poses(recorder.positions[row, nodes], matrix(recorder.quaternions[row, nodes]))
        if first:
            self._motion.put(here)
        speeds = self._motion.motion(here)
        motion = SolidMotion(
            here.p,
            here.R,
            speeds[:, :3],
            turn(here.R, speeds[:, 3:]),
            recorder.alive[row, nodes],
            np.ones(len(nodes), dtype=bool),
            np.zeros(len(nodes), dtype=bool),
        )
        if self.owner is not None:
            motion = motion.joined(self.owner.solid_motion().selected(self._movable))
        self.troupe.update_obstacles(motion)

    def push_solids(self) -> None:
        """Passes the impulses since the last update to the troupe of the movable solids."""
        if self.owner is None:
            return
        impulses, angular_impulses = self.troupe.obstacle_impulses()
        count = len(self._movable)
        linear, angular = np.zeros((count, 3)), np.zeros((count, 3))
        linear[self._movable] = impulses[len(self.nodes) :]
        angular[self._movable] = angular_impulses[len(self.nodes) :]
        self.owner.push_solids(linear, angular)


def coupling_of(
    scene: Scene,
    troupes: Sequence[Troupe],
    recorder: Recorder,
    attachments: Sequence[Attachment],
    obstacles: Callable[[], Sequence[Obstacle]],
) -> ContactCoupling | None:
    """Returns the coupling of a scene, None if no troupe collides or nothing is in its way.

    Args:
        scene: the scene.
        troupes: all troupes, in the order of their nodes.
        recorder: the take under construction.
        attachments: all attachments, parents first.
        obstacles: computes the solids of all troupes.
    """
    troupe = next((t for t in troupes if t.hits_obstacles), None)
    if troupe is None:
        return None
    hard = {m.name for m in scene.cast if isinstance(m, Creature | Dancer | Prop)}
    # A carried solid moves with its carrier.
    _, carried = split_attachments(attachments, node_range(troupes, troupe))
    carried_nodes = {int(node) for attachment in carried for node in attachment.nodes}
    owner = pushed_troupe(troupes)
    movable, pushed_nodes = list[Obstacle](), range(0)
    if owner is not None:
        pushed_nodes = node_range(troupes, owner)
    fixed = [
        o
        for o in obstacles()
        if o.performer in hard and o.node not in carried_nodes and o.node not in pushed_nodes
    ]
    if owner is not None:
        first = pushed_nodes.start
        movable = [replace(solid, node=first + solid.node) for solid in owner.movable_solids()]
    if not fixed and not movable:
        return None
    moving = {m.name for m in scene.cast if not (isinstance(m, Prop) and _is_still(m))}
    still = owner is None and moving.isdisjoint(o.performer for o in fixed)
    return ContactCoupling(troupe, recorder, fixed, movable, owner, still)


def _is_still(prop: Prop) -> bool:
    moved = prop.keyframes, prop.velocity, prop.spin_deg, prop.force, prop.held, prop.parent
    return not any(moved)
