"""Character yard: characters without a scene, and measures of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import CharacterArrays
from pipeline.simulation.characters.body_plan import BodyPlan, character_arrays
from pipeline.simulation.characters.broad_phase import Workspace, workspace_for
from pipeline.simulation.characters.character_plans import LINK_NAMES, RAGDOLL, person_plan
from pipeline.simulation.characters.contact_response import TouchLog, new_touch_log
from pipeline.simulation.characters.limb_limits import joint_excess
from pipeline.simulation.characters.link_contacts import closest_points
from pipeline.simulation.characters.person_record import PERSON
from pipeline.simulation.characters.playthings import ball_plan, box_plan
from pipeline.simulation.characters.verlet_step import advance
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, entry
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.terrain_grid import Grid, grid_of
from pipeline.simulation.people.proportions import ADULT, CHILD
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.terrain.heightfield import HeightField

DT, COUNT = 1.0 / 96.0, 3
LEFT_LEG = (LINK_NAMES.index("thigh_l"), LINK_NAMES.index("shin_l"))
RIGHT_LEG = (LINK_NAMES.index("thigh_r"), LINK_NAMES.index("shin_r"))
FLAT = grid_of(HeightField(np.zeros((3, 3)), (60.0, 60.0)))


@dataclass
class Yard:
    """Characters with their terrain and buffers."""

    arrays: CharacterArrays
    grid: Grid = FLAT
    level: bool = True
    gravity: float = 9.81
    dt: float = DT
    count: int = COUNT
    workspace: Workspace = field(init=False)
    log: TouchLog = field(init=False)

    def __post_init__(self) -> None:
        self.workspace, self.log = workspace_for(self.arrays), new_touch_log()

    @property
    def h(self) -> float:
        """The sub-step [s]."""
        return self.dt / self.count

    @property
    def velocities(self) -> Array:
        """(N, 3) of the nodes [m/s]."""
        result: Array = (self.arrays.p - self.arrays.previous) / self.h
        return result

    def set_velocities(self, v: Array) -> None:
        """Give nodes (N, 3) velocities [m/s]."""
        self.arrays.nodes["previous"] = self.arrays.p - self.h * v

    def step(self, steps: int = 1) -> None:
        """Advance by a number of steps."""
        for _ in range(steps):
            advance(
                *(
                    self.arrays,
                    zero_records(0, PERSON),
                    self.grid,
                    self.level,
                    self.workspace,
                    self.log,
                ),
                *(self.gravity, self.dt, self.count),
            )


def random_rotation(rng: np.random.Generator) -> Array:
    """Return a uniformly random rotation."""
    q = rng.normal(size=4)
    return matrix(q / np.linalg.norm(q))


def build_yard(plans: Sequence[BodyPlan], places: Sequence[Array], **settings: object) -> Yard:
    return Yard(character_arrays(plans, places), **settings)  # type: ignore[arg-type]


def undamped(plan: BodyPlan) -> BodyPlan:
    """Return a person without damping and limits."""
    links = tuple(k._replace(damping=0.0) for k in plan.links if k.shortest is None)
    return plan._replace(
        links=links, limbs=plan.limbs[:0], pairs=(), air_damping=0.0, ground_damping=0.0
    )


PLANS = (
    *(person_plan(body) for body in (ADULT, CHILD, RAGDOLL)),
    ball_plan(0.12, 0.4),
    box_plan((0.5, 0.5, 0.5), 9.0),
    box_plan((0.42, 0.42, 1.5), 26.0),
)


def random_crowd(seed: int) -> Yard:
    """Return two to six overlapping characters of any kind, thrown and spinning.

    One box or bench at most; for more of them see `pile`.
    """
    rng = np.random.default_rng(seed)
    plans = [PLANS[int(rng.integers(4))] for _ in range(int(rng.integers(2, 7)))]
    if rng.random() < 0.5:
        plans[0] = PLANS[int(rng.integers(4, 6))]
    places, velocities = [], []
    for plan in plans:
        p = plan.rest @ random_rotation(rng).T
        p -= p.mean(axis=0)
        way = rng.normal(size=3)
        v = way * rng.uniform(0.0, 20.0) / np.linalg.norm(way)
        velocities.append(v + np.cross(rng.normal(size=3) * rng.uniform(0.0, 6.0), p))
        places.append(p + rng.uniform([-0.8, 0.9, -0.8], [0.8, 2.2, 0.8]))
    yard = build_yard(plans, places)
    yard.set_velocities(np.concatenate(velocities))
    return yard


def pile(seed: int) -> Yard:
    """Return one or two people under two to four thrown boxes and benches."""
    rng = np.random.default_rng(seed + 5000)
    plans = [PLANS[int(rng.integers(3))] for _ in range(int(rng.integers(1, 3)))]
    plans += [PLANS[int(rng.integers(4, 6))] for _ in range(int(rng.integers(2, 5)))]
    places, velocities = [], []
    for k, plan in enumerate(plans):
        p = plan.rest @ random_rotation(rng).T
        p -= p.mean(axis=0)
        way = rng.normal(size=3)
        v = way * rng.uniform(0.0, 6.0) / np.linalg.norm(way)
        velocities.append(v + np.cross(rng.normal(size=3) * rng.uniform(0.0, 4.0), p))
        above = rng.uniform([-0.6, 0.9, -0.6], [0.6, 1.2, 0.6])
        places.append(p + above + [0.0, 0.55 * k, 0.0])
    yard = build_yard(plans, places)
    yard.set_velocities(np.concatenate(velocities))
    return yard


def link_length_error(arrays: CharacterArrays) -> float:
    """Return the largest relative length error of rigid links."""
    least, most = arrays.links["length_limits"].T
    rigid = (least == most) & (least > 0.0)
    apart = arrays.p[arrays.links["ends"][:, 0]] - arrays.p[arrays.links["ends"][:, 1]]
    return float(np.abs(np.linalg.norm(apart, axis=1)[rigid] / least[rigid] - 1.0).max(initial=0.0))


@entry
def largest_joint_excess(nodes: Records, limbs: Records) -> float:
    """Return the largest distance of a joint from where it may point, in upper lengths."""
    largest = 0.0
    for n in range(len(limbs)):
        largest = max(largest, joint_excess(nodes, limbs[n]))
    return largest


@entry
def character_overlap(nodes: Records, links: Records) -> float:
    """Return the deepest overlap of links of different characters [m]."""
    deepest = 0.0
    for a in range(len(links)):
        for b in range(a + 1, len(links)):
            one, other = links[a], links[b]
            if one.radius > 0.0 and other.radius > 0.0 and one.owner != other.owner:
                deepest = max(deepest, link_overlap(nodes, one, other))
    return deepest


@entry
def leg_overlap(nodes: Records, links: Records) -> float:
    """Return the overlap of the first person's legs [m], less than 0 if apart."""
    deepest = -9.0
    for a in LEFT_LEG:
        for b in RIGHT_LEG:
            deepest = max(deepest, link_overlap(nodes, links[a], links[b]))
    return deepest


@compiled
def link_overlap(nodes: Records, one: Record, other: Record) -> float:
    """Return the overlap of two links [m], less than 0 if they are apart."""
    p, q = nodes[one.ends[0]].p, nodes[one.ends[1]].p
    r, s = nodes[other.ends[0]].p, nodes[other.ends[1]].p
    u = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    v = (s[0] - r[0], s[1] - r[1], s[2] - r[2])
    t, w = closest_points((p[0], p[1], p[2]), u, (r[0], r[1], r[2]), v)
    squared = 0.0
    for k in range(3):
        squared += (p[k] + t * u[k] - r[k] - w * v[k]) ** 2
    off: float = one.radius + other.radius - math.sqrt(squared)
    return off
