"""The troupe of inchworms.

The rear end is planted and the front end reaches forward until the worm is stretched; then the
front end is planted and the rear end is drawn up behind it, while the middle rises into a loop.
The planted end is the base of the chain, the other one its tip.

Source: Sims 1987, 5.3 and figure 5.7.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.locomotion.inching.inchworm_chain import FRONT, REAR, InchwormChain
from pipeline.simulation.locomotion.inching.inchworm_pace import resolve_inchworm_pace
from pipeline.simulation.locomotion.inching.inchworm_pose import (
    InchwormPose,
    InchwormTrack,
    solve_pose,
)
from pipeline.simulation.locomotion.inching.inchworm_steps import Inchworm, InchwormStep, feet_at
from pipeline.simulation.locomotion.inventory import (
    assign_looks,
    creature_skins,
    creature_solids,
    parent_links,
)
from pipeline.simulation.locomotion.swing.swing_trajectory import touchdown_speed
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.take import Channel, Contact, Mesh, Node, Part, TakeNote
from pipeline.simulation.troupe import Facts, Troupe, World
from pipeline.spec.creature import Creature
from pipeline.spec.script import Instruction

FOOT_MISS = 1e-4
"""Distance between a foot and its goal that is worth a note [m]."""


class InchwormTroupe(Troupe):
    """All inchworms.

    Attributes:
        phases: of the gaits, whole cycles included.
        steps: current step of each worm.
        halted: whether each worm found no foothold.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Creature, Figure]], world: World, materials: Sequence[str]
    ) -> None:
        _refuse_direction(cast, world.instructions)
        self.world = world
        self.worms = [
            _build_inchworm(number, member, figure, world) for number, member, figure in cast
        ]
        self.materials = list(materials)
        self.inventory = describe(self.worms, materials, world.clock.rows)
        self.step = 0
        self.steps = [worm.lie_down() for worm in self.worms]
        self.phases = [0.0 for _ in self.worms]
        self.halted = [not worm.walks for worm in self.worms]
        self._contacts: list[Contact] = []
        self._notes: list[TakeNote] = []
        self._row_notes: list[TakeNote] = []
        self._kept: list[tuple[int, tuple[InchwormStep, ...], tuple[float, ...]]] = []
        for w in range(len(self.worms)):
            self._start_step(0, w)

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Refuse instructions to inchworms.

        Raises:
            SceneError: the instruction is for an inchworm.
        """
        if any(worm.name == instruction.who for worm in self.worms):
            raise SceneError([_undirected(instruction, path)])

    def advance(self, step: int) -> None:
        """Advance from `step` to the next."""
        self._contacts.clear()
        self._notes.clear()
        self.step = step + 1
        for w, worm in enumerate(self.worms):
            if not self.halted[w]:
                rate = self.world.clock.dt / worm.pace.cycle
                self._advance_worm(step, w, step * rate, self.step * rate)

    def buffer_row(self) -> None:
        """Append the current state as the next row."""
        self._kept.append((self.step, tuple(self.steps), tuple(self.phases)))

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all kept rows."""
        rows.alive[:] = True
        node, channel = 0, 0
        for w, worm in enumerate(self.worms):
            own = self._poses(w)
            links, joints = own.positions.shape[1], own.q.shape[1]
            rows.positions[:, node : node + links] = own.positions
            rows.rotations[:, node : node + links] = own.rotations
            phases = np.array([phases[w] for _, _, phases in self._kept])
            # Worms halt at the end of a step.
            going = [
                worm.walks and p < s[w].down
                for (_, s, _), p in zip(self._kept, phases, strict=True)
            ]
            speed = np.where(going, worm.pace.stride / worm.pace.cycle, 0.0)
            rows.values[:, channel] = np.mod(phases, 1.0)
            rows.values[:, channel + 1] = speed
            rows.values[:, channel + 2 : channel + 2 + joints] = own.q
            node, channel = node + links, channel + 2 + joints
        self._kept.clear()

    def facts(self) -> Facts:
        """Return the contacts and notes of the last step."""
        # Rows may also have been written before the step.
        notes, self._row_notes = (*self._notes, *self._row_notes), []
        return Facts(tuple(self._contacts), notes)

    # --- one step ---------------------------------------------------------------

    def _advance_worm(self, step: int, w: int, before: float, after: float) -> None:
        """Advance worm `w` between two phases; land and start the steps that are due."""
        while not self.halted[w] and (down := self.steps[w].down) <= after:
            self._record_touch(step, w, (down - before) / (after - before))
            self._start_step(step, w)
        self.phases[w] = self.steps[w].down if self.halted[w] else after

    def _start_step(self, step: int, w: int) -> None:
        """Swap base and tip and start the step of the other end; halt without a foothold."""
        if self.halted[w]:
            return
        planned = self.worms[w].next(self.steps[w])
        if planned is None:
            self.halted[w] = True
            end = FRONT if self.steps[w].end == REAR else REAR
            part = f"{self.worms[w].name}.{self.worms[w].chain.feet[end].limb.name}"
            _, middles = self.worms[w].track.pose(self.steps[w].planted[None])
            x, _, z = middles[0]
            text = f"no foothold within reach, at [{x:.2f}, {z:.2f}]"
            self._notes.append(TakeNote("stopped", step, part, text))
            return
        self.steps[w] = planned

    def _record_touch(self, step: int, w: int, fraction: float) -> None:
        """Record the landing of the moving end, `fraction` of a step after `step`."""
        worm, current = self.worms[w], self.steps[w]
        foot, track = worm.chain.feet[current.end], worm.track
        _, middles = track.pose(np.stack([current.start, current.finish]))
        x, z = middles[1, 0], middles[1, 2]
        normal = track.ground.normal(x, z)
        time = 0.5 * worm.pace.cycle
        speed = touchdown_speed(middles[0], middles[1], current.height, normal, time)
        mass = FigureMass(worm.chain.figure).mass_of(foot.limb.links)
        self._contacts.append(
            Contact(
                step=step,
                fraction=min(max(fraction, 0.0), float(np.nextafter(1.0, 0.0))),
                performer=worm.name,
                part=f"{worm.name}.{foot.limb.name}",
                other="terrain",
                place=(float(x), float(track.ground.height(x, z)), float(z)),
                normal=(float(normal[0]), float(normal[1]), float(normal[2])),
                speed=speed,
                energy=0.5 * mass * speed * speed,
                material=foot.link.material or self.materials[w],
                surface=track.ground.material,
                size=foot.limb.length,
            )
        )

    # --- rows ---------------------------------------------------------------------

    def _poses(self, w: int) -> InchwormPose:
        """Return worm `w` in all kept rows; rows with the same base are solved together."""
        worm, n = self.worms[w], len(self._kept)
        steps = [steps[w] for _, steps, _ in self._kept]
        phases = np.array([phases[w] for _, _, phases in self._kept])
        skeleton = worm.chain.figure.skeleton
        links, joints = len(skeleton.links), len(skeleton.parents)
        poses = InchwormPose(
            np.zeros((n, links, 3)), np.zeros((n, links, 3, 3)), np.zeros((n, joints)), np.zeros(n)
        )
        ends = np.array([step.end for step in steps])
        for end in (REAR, FRONT):
            rows = np.flatnonzero(ends == end)
            if len(rows):
                rear, front = feet_at([steps[i] for i in rows], phases[rows], end)
                solved = solve_pose(worm.chain, worm.track, 1 - end, rear, front)
                for name in ("positions", "rotations", "q", "residual"):
                    getattr(poses, name)[rows] = getattr(solved, name)
        for row in np.flatnonzero(poses.residual > FOOT_MISS):
            part = f"{worm.name}.{worm.chain.feet[ends[row]].limb.name}"
            gap = f"{1000.0 * poses.residual[row]:.2g} mm from where it is to be"
            self._row_notes.append(TakeNote("clamped", self._kept[row][0], part, gap))
        return poses


def _refuse_direction(
    cast: Sequence[tuple[int, Creature, Figure]], instructions: Sequence[tuple[str, Instruction]]
) -> None:
    """Refuse instructions to inchworms, and their `look_at`.

    Raises:
        SceneError: there are any.
    """
    names = {member.name for _, member, _ in cast}
    problems = [
        _undirected(instruction, path)
        for path, instruction in instructions
        if instruction.who in names
    ]
    problems += [
        Problem(f"cast[{i}].look_at", f"'{member.name}' is an inchworm, which looks nowhere")
        for i, member, _ in cast
        if member.look_at is not None
    ]
    if problems:
        raise SceneError(problems)


def _undirected(instruction: Instruction, path: str) -> Problem:
    message = f"'{instruction.who}' is an inchworm, which follows no script"
    return Problem(f"{path}.who", message)


def _build_inchworm(number: int, member: Creature, figure: Figure, world: World) -> Inchworm:
    chain = InchwormChain.of(figure)
    x, z = member.at[0], member.at[-1]
    track = InchwormTrack(
        world.ground, np.array([float(x), float(z)]), float(np.radians(member.heading_deg))
    )
    return Inchworm(
        member.name,
        number,
        chain,
        resolve_inchworm_pace(number, member, chain),
        track,
        member.walk is not None,
    )


def describe(worms: Sequence[Inchworm], materials: Sequence[str], rows: int) -> Inventory:
    """Return nodes, channels, meshes and parts of worms.

    Args:
        worms: all of them.
        materials: of each worm's links that name none.
        rows: of the take.
    """
    nodes, channels = list[Node](), list[Channel]()
    meshes, parts, looks = list[Mesh](), list[Part](), list[Mesh]()
    for worm, material in zip(worms, materials, strict=True):
        figure, first = worm.chain.figure, len(nodes)
        links = figure.skeleton.links
        for link, above in zip(links, parent_links(figure), strict=True):
            x, y, z = (float(c) for c in link.ends[0])
            parent = -1 if above is None else first + above
            nodes.append(Node(f"{worm.name}.{link.name}", worm.name, parent, (x, y, z)))
        channels.append(Channel(f"{worm.name}.gait_phase", "1"))
        channels.append(Channel(f"{worm.name}.speed", "m/s"))
        names = figure.skeleton.joint_names
        channels.extend(Channel(f"{worm.name}.{joint}", "rad") for joint in names)
        solids = creature_solids(worm.name, figure, first, len(meshes), material, rows)
        meshes.extend(solids[0])
        parts.extend(assign_looks(solids[1], figure, len(looks)))
        looks.extend(creature_skins(figure, first))
    return Inventory(tuple(nodes), tuple(channels), tuple(meshes), tuple(parts), looks=tuple(looks))
