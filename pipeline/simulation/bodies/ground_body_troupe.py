"""Ground bodies: rigid bodies that fall on the terrain, bounce, roll and come to rest.

Source: Sims 1987, 7.1 and ch. 12.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.body_model import build_body, mesh_of, seen_of
from pipeline.simulation.bodies.sliding_tracker import (
    ROLLING_SLIP_RATIO,
    SlidingInterval,
    SlidingTracker,
)
from pipeline.simulation.dynamics.rigid_body import Bodies, BodyModel, State, dot, unrotate
from pipeline.simulation.dynamics.terrain_bodies import GroundImpact, TerrainBodies
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.spatial import Array, heading, matrix, quaternion
from pipeline.simulation.take import Contact, Mesh, Node, Note, Part
from pipeline.simulation.troupe import Facts, Rows, Troupe, World
from pipeline.spec.body import Body

DROP_DEPTH = 10.0
"""Depth below the lowest ground at which what has left the terrain is dropped [m]."""

MAX_START_DEPTH = 1e-3
"""Depth in the ground at the begin that is refused, in sizes of the body."""

BISECTIONS = 60

Member = tuple[int, Body]
"""Place in the cast, and words."""


class GroundBodyTroupe(Troupe):
    """All rigid bodies of a scene.

    Raises:
        SceneError: a shape is no solid, or a body begins in the ground.
    """

    def __init__(self, cast: Sequence[Member], world: World, materials: Sequence[str]) -> None:
        self.world = world
        self.names = [member.name for _, member in cast]
        self.materials = materials
        builds = _builds(cast)
        bodies = Bodies.of(builds)
        self.bouncing = TerrainBodies(bodies, _start(cast), world.ground)
        _put_down(cast, self.bouncing)
        _refuse_overlap(cast, self.bouncing)
        self.inventory = _inventory(cast, builds, materials, world.clock.rows)
        self._floor = float(world.ground.field.heights.min()) - DROP_DEPTH
        self.alive = np.ones(len(cast), dtype=bool)
        dt = world.clock.dt
        self._rolls, self._slides = (
            SlidingTracker("roll", len(cast), dt, world.detect.roll),
            SlidingTracker("slide", len(cast), dt, world.detect.slide),
        )
        self._contacts: tuple[Contact, ...] = ()
        self._notes: tuple[Note, ...] = ()
        self._kept: list[tuple[Array, Array, Array]] = []

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        impacts = self.bouncing.advance(self.world.clock.dt)
        rubs = self._rubs(step + 1)
        self._contacts = (
            *(self._contact(step, impact) for impact in impacts),
            *(self._rubbed(rub) for rub in rubs),
        )
        lost = np.flatnonzero(self.alive & (self.bouncing.state.p[:, 1] < self._floor))
        self.alive[lost] = False
        self.bouncing.drop(lost)
        text = f"left the terrain, and was dropped {DROP_DEPTH:g} m below it"
        self._notes = tuple(Note("dropped", step + 1, self.names[i], text) for i in lost)

    def buffer_row(self) -> None:
        """Keep the present state as the next row."""
        state = self.bouncing.state
        self._kept.append((state.p.copy(), state.q.copy(), self.alive.copy()))

    def write(self, rows: Rows) -> None:
        """Write all rows kept."""
        p, q, alive = (np.array(values) for values in zip(*self._kept, strict=True))
        rows.positions[:] = p
        rows.rotations[:] = matrix(q)
        rows.alive[:] = alive
        self._kept.clear()

    def facts(self) -> Facts:
        """Return what struck the ground in the last step, and what was lost."""
        return Facts(self._contacts, self._notes)

    def _rubs(self, step: int) -> list[SlidingInterval]:
        """Return what has ended to roll or to slide."""
        touches, place, normal, v, slip = self.bouncing.touching()
        final = step == self.world.clock.last_step
        speeds = [np.sqrt(dot(u, u)) for u in (v - dot(v, normal)[:, None] * normal, slip)]
        ball = self.bouncing.bodies.radius > 0.0
        rolls = ball & (speeds[1] <= ROLLING_SLIP_RATIO * speeds[0])
        where = place, normal, final
        return [
            *self._rolls.look(step, touches & rolls, speeds[0], *where),
            *self._slides.look(step, touches & ~rolls, speeds[1], *where),
        ]

    def _rubbed(self, rub: SlidingInterval) -> Contact:
        i, bodies = rub.body, self.bouncing.bodies
        clock = self.world.clock
        a_row = clock.steps // clock.samples
        # At rows, of which the first and the last may lie a little outside.
        rows = range(rub.first // a_row, rub.last // a_row + 1)
        at = [min(max(row * a_row - rub.first, 0), len(rub.speeds) - 1) for row in rows]
        return Contact(
            step=rub.first,
            fraction=0.0,
            performer=self.names[i],
            part="",
            other="terrain",
            place=rub.place,
            normal=rub.normal,
            speed=rub.speed,
            energy=0.5 * float(bodies.mass[i]) * rub.speed**2,
            material=self.materials[i],
            surface=self.world.ground.material,
            size=float(bodies.size[i]),
            kind=rub.kind,
            until=rub.last,
            speeds=tuple(rub.speeds[k] for k in at),
            places=tuple(rub.places[k] for k in at),
        )

    def _contact(self, step: int, impact: GroundImpact) -> Contact:
        i = impact.body
        fraction = min(impact.time / self.world.clock.dt, math.nextafter(1.0, 0.0))
        return Contact(
            step=step,
            fraction=fraction,
            performer=self.names[i],
            part="",
            other="terrain",
            place=impact.place,
            normal=impact.normal,
            speed=impact.speed,
            energy=impact.energy,
            material=self.materials[i],
            surface=self.world.ground.material,
            size=float(self.bouncing.bodies.size[i]),
            kind="hit",
        )


def _builds(cast: Sequence[Member]) -> list[BodyModel]:
    """Return the bodies as they are built.

    Raises:
        SceneError: shapes are no solids.
    """
    builds, problems = list[BodyModel](), list[Problem]()
    for i, member in cast:
        try:
            builds.append(build_body(member.body, f"cast[{i}].body"))
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(problems)
    return builds


def _start(cast: Sequence[Member]) -> State:
    """Return how bodies begin; the heights of those without one are found later."""
    p, R, w = [], [], []
    for _, member in cast:
        x, z = member.at[0], member.at[-1]
        p.append([x, member.at[1] if len(member.at) == 3 else 0.0, z])
        look = rotation_from_angles(np.radians(np.array([member.rotation_deg])))[0]
        R.append(heading(math.radians(member.heading_deg)) @ look)
        w.append(np.radians(member.spin_deg))
    R_WB = np.array(R)
    v = np.array([member.velocity for _, member in cast], dtype=float)
    return State(np.array(p, dtype=float), quaternion(R_WB), v, unrotate(R_WB, np.array(w)))


def _put_down(cast: Sequence[Member], bouncing: TerrainBodies) -> None:
    """Put bodies whose height is not given on the ground, by halving what is between."""
    rows = np.array([len(member.at) == 2 for _, member in cast])
    if not rows.any():
        return
    field, reach, p = bouncing.ground.field, bouncing.bodies.reach, bouncing.state.p
    low = np.full(len(rows), float(field.heights.min())) - reach
    high = np.full(len(rows), float(field.heights.max())) + reach
    for _ in range(BISECTIONS):
        p[rows, 1] = 0.5 * (low + high)[rows]
        deep = bouncing.depths() > 0.0
        low, high = np.where(deep, p[:, 1], low), np.where(deep, high, p[:, 1])
    p[rows, 1] = high[rows]
    bouncing.find_contacts()


def _refuse_overlap(cast: Sequence[Member], bouncing: TerrainBodies) -> None:
    """Refuse bodies that begin in the ground.

    Raises:
        SceneError: there are any.
    """
    depths = bouncing.depths()
    problems = [
        Problem(
            f"cast[{i}].at",
            f"'{member.name}' begins {depth:.3g} m deep in the terrain; raise it, or give "
            f"[x, z] to put it on the ground",
        )
        for (i, member), depth, size in zip(cast, depths, bouncing.bodies.size, strict=True)
        if depth > MAX_START_DEPTH * size
    ]
    if problems:
        raise SceneError(problems)


def _inventory(
    cast: Sequence[Member], builds: Sequence[BodyModel], materials: Sequence[str], rows: int
) -> Inventory:
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    for i, ((_, member), build, material) in enumerate(zip(cast, builds, materials, strict=True)):
        nodes.append(Node(member.name, member.name, -1, (0.0, 0.0, 0.0)))
        for suffix, solid, made_of in seen_of(member.body, build, material):
            size = float(np.ptp(solid.vertices, axis=0).max())
            name = member.name + suffix
            parts.append(Part(name, member.name, len(meshes), made_of, size, (0, rows)))
            meshes.append(mesh_of(solid, i))
    return Inventory(tuple(nodes), (), tuple(meshes), tuple(parts))
