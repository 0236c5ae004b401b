"""Pronkers: the troupe of creatures that hop.

Each goes through a step at its own pace, from event to event, see `hopping`; what joins feet
and bodies is worked out for many rows at once, see `posing`.

Source: Sims 1987, 7.4 and ch. 11.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.carriage.idle import gather_idlers
from pipeline.simulation.locomotion.carriage.looking import looks_in
from pipeline.simulation.locomotion.footing.folds import folds_of
from pipeline.simulation.locomotion.herd import gather
from pipeline.simulation.locomotion.inventory import NodeTable, describe, foot_materials
from pipeline.simulation.locomotion.pronking.falling import Fall
from pipeline.simulation.locomotion.pronking.happening import Happening
from pipeline.simulation.locomotion.pronking.hopping import Hopping
from pipeline.simulation.locomotion.pronking.kept import Kept
from pipeline.simulation.locomotion.pronking.limp import LimpFall
from pipeline.simulation.locomotion.pronking.posing import Moment, Posing
from pipeline.simulation.locomotion.pronking.pronker import pronkers_of
from pipeline.simulation.locomotion.pronking.stiff import StiffFall
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, ContactKind, Note
from pipeline.simulation.troupe import Facts, Rows, World
from pipeline.spec.cast import Creature
from pipeline.spec.pronk import Pronk

SLIP = 1e-4
"""Distance between a foot and its foothold that is worth a note [m]."""

CYCLE = {"flight": (0.0, 0.5), "landing": (0.5, 0.25), "pushing": (0.75, 0.25)}
"""Where the phases begin in a cycle that runs from 0 to 1, and how long they are."""

CONTACTS: dict[str, ContactKind] = {"touch": "touch", "lift": "lift", "body": "hit"}
FALLS: dict[str, Callable[[Figure], Fall]] = {"ragdoll": LimpFall, "rigid": StiffFall}
NOTES = {
    "toppled": "toppled",
    "saturated": "clamped",
    "stopped": "stopped",
    "misplaced": "misplaced",
    "tripped": "tripped",
    "dropped": "dropped",
}


class Pronkers:
    """All creatures that hop.

    Attributes:
        herd: what they are.
        hoppings: how each is.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Creature, Figure]], world: World, materials: Sequence[str]
    ) -> None:
        self.world, self.materials = world, list(materials)
        self.herd = herd = gather(cast, world.moods)
        idlers = gather_idlers(herd, world.seed)
        table = NodeTable.of(herd, idlers)
        words = [member.pronk or Pronk() for _, member, _ in cast]
        self.pronkers = pronkers_of(herd, [number for number, _, _ in cast], words)
        above = [float(m.at[1]) if len(m.at) == 3 else None for _, m, _ in cast]
        row_dt = world.clock.dt * world.clock.steps / world.clock.samples
        self.posing = Posing(herd, world.ground, idlers, table, folds_of(herd), row_dt)
        self.kept = Kept(self.posing, looks_in(herd, cast), world.clock.dt)
        self.hoppings = [
            Hopping(
                of,
                world.ground,
                up,
                FALLS[of.words.fall](herd.figures[c]),
                partial(self.kept.limbs, c),
            )
            for c, (of, up) in enumerate(zip(self.pronkers, above, strict=True))
        ]
        self.inventory = describe(herd, idlers, table, materials, world.clock.rows)
        self._feet = foot_materials(herd, materials)
        self.step = 0
        self._contacts: list[Contact] = []
        self._notes: list[Note] = []

    def read(self, orders: Orders) -> None:
        """Take in nothing: who hops is not directed yet, which is said when it is asked for."""

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        self._contacts.clear()
        self._notes.clear()
        end = (step + 1) * self.world.clock.dt
        for c, hopping in enumerate(self.hoppings):
            hopping.happened.clear()
            hopping.advance(end)
            for one in hopping.happened:
                self._tell(step, c, one)
        self.step = step + 1

    def keep(self) -> None:
        """Keep the present state as the next row."""
        poses = [hopping.pose() for hopping in self.hoppings]
        hanging = ((c, one.fall.q) for c, one in enumerate(self.hoppings))
        self.kept.keep(
            Moment(
                step=self.step,
                R=np.stack([moved.R for moved, _ in poses]),
                p=np.stack([moved.origin for moved, _ in poses]),
                tips=np.concatenate([tips for _, tips in poses]),
                down=np.concatenate([one.state.down for one in self.hoppings]),
                phase=np.array([_phase(one) for one in self.hoppings]),
                speed=np.array([np.hypot(*one.state.v[[0, 2]]) for one in self.hoppings]),
                limp=np.array([one.state.phase == "fallen" for one in self.hoppings]),
                hanging={c: q for c, q in hanging if q is not None},
            )
        )

    def write(self, rows: Rows) -> None:
        """Write nodes and channels of all rows kept."""
        first = 0
        for moments, poses in self.kept.taken():
            here = slice(first, first + len(moments))
            rows.positions[here], rows.rotations[here] = poses.positions, poses.rotations
            rows.alive[here] = True
            rows.values[here] = poses.values
            for row, leg in np.argwhere(poses.residual > SLIP):
                gap = 1000.0 * float(poses.residual[row, leg])
                text = f"{gap:.2g} mm from its foothold"
                self._notes.append(Note("clamped", moments[row].step, self._part(int(leg)), text))
            first = here.stop

    def facts(self) -> Facts:
        """Return the contacts and notes of the last step."""
        return Facts(tuple(self._contacts), tuple(self._notes))

    def _part(self, leg: int) -> str:
        return f"{self.herd.names[self.herd.owner[leg]]}.{self.herd.leg_names[leg]}"

    def _tell(self, step: int, c: int, one: Happening) -> None:
        """Take down an event of creature `c`."""
        herd, name = self.herd, self.herd.names[c]
        link = herd.figures[c].skeleton.links[one.link]
        leg = int(herd.first_leg[c]) + one.leg
        part = f"{name}.{link.name}" if one.leg < 0 else self._part(leg)
        if one.kind in NOTES:
            self._notes.append(Note(NOTES[one.kind], step, part, one.text))
            return
        dt = self.world.clock.dt
        fraction = min(max(one.time / dt - step, 0.0), float(np.nextafter(1.0, 0.0)))
        body = link.material or self.materials[c]
        length = self._length(c, one.link)
        self._contacts.append(
            Contact(
                step=step,
                fraction=fraction,
                performer=name,
                part=part,
                other="terrain",
                place=_plain(one.place),
                normal=_plain(one.normal),
                speed=one.speed,
                energy=one.energy,
                material=body if one.leg < 0 else self._feet[leg],
                surface=self.world.ground.material,
                size=length if one.leg < 0 else float(herd.legs.lengths[leg]),
                kind=CONTACTS[one.kind],
            )
        )

    def _length(self, c: int, link: int) -> float:
        """Return the size of a link [m]."""
        figure = self.herd.figures[c]
        return next(piece.size for piece in figure.pieces if piece.link == link)


def _phase(hopping: Hopping) -> float:
    """Return where in the cycle of a jump a creature is, 0 to 1; 0 before and after all."""
    state = hopping.state
    if state.phase not in CYCLE:
        return 0.0
    begins, long = CYCLE[state.phase]
    v = float(state.v[1])
    if state.phase == "flight":
        up = float(state.lift[1][1])
        done = 0.5 * (1.0 - v / up) if up > 0.0 else 0.5
    elif state.phase == "landing":
        done = 1.0 - max(state.until - state.time, 0.0) / 0.3
    else:
        up = v + float(state.a[1]) * (state.until - state.time)
        done = v / up if up > 0.0 and np.isfinite(up) else 0.0
    return begins + long * min(max(done, 0.0), 1.0)


def _plain(v: Array) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in v)
    return x, y, z
