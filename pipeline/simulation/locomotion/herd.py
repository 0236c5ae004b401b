"""Herd: the constants of all walking creatures as arrays, creature by creature and leg by leg."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.bend_path import bending_joints
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.foot_link import last_links, slopes
from pipeline.simulation.figures.joint_limits import LEVEL
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_chains import ChainGroup, group_chains
from pipeline.simulation.figures.network import ARM
from pipeline.simulation.figures.skeleton import Limb
from pipeline.simulation.locomotion.gaits.moods import apply_mood, blend_moods
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.gaits.pace_choice import choose_pace
from pipeline.simulation.locomotion.gaits.stride_limits import LegLayout
from pipeline.simulation.refusals import Refusals
from pipeline.simulation.spatial import Array
from pipeline.spec.creature import Creature
from pipeline.spec.mood import Mood


@dataclass(frozen=True, eq=False)
class Herd:
    """C creatures with L legs in all.

    Attributes:
        names, figures: of the creatures.
        starts: (C, 2) x and z at the start [m].
        headings: (C,) at the start [rad].
        leg_layouts: legs of the creatures at rest.
        neutral_paces, paces: at the start, without and with their moods.
        cycle, stride, body_height, bounciness, lateral_offset, running: (C,) of `paces`, see
            `Pace`.
        beats: (C,) different foot-down phases in a cycle.
        belly: (C,) depth of the bodies below their frames [m].
        walks: (C,) whether the creature walks at all.
        footprint: (C, 2) half extent of the feet at rest along x and z [m].
        owner: (L,) creature of each leg.
        leg_names, legs: names and joints of the legs.
        rest: (L, 2) x and z of the feet at rest, relative to the body [m].
        up, down: (L,) foot-up and foot-down phases.
        step_height, foot_radius: (L,) height of a swing, and radius of the foot [m].
    """

    names: tuple[str, ...]
    figures: tuple[Figure, ...]
    starts: Array
    headings: Array
    leg_layouts: tuple[LegLayout, ...]
    neutral_paces: tuple[Pace, ...]
    paces: tuple[Pace, ...]
    cycle: Array
    stride: Array
    body_height: Array
    bounciness: Array
    lateral_offset: Array
    running: Array
    beats: Array
    belly: Array
    walks: NDArray[np.bool_]
    footprint: Array
    owner: NDArray[np.int64]
    leg_names: tuple[str, ...]
    legs: LimbBatch
    rest: Array
    up: Array
    down: Array
    step_height: Array
    foot_radius: Array

    @cached_property
    def swings(self) -> Array:
        """(L,) fractions of a cycle that the feet are in the air."""
        return np.mod(self.down - self.up, 1.0)

    @cached_property
    def upright(self) -> NDArray[np.bool_]:
        """(C,) which creatures walk on two legs and have arms, as people."""
        two = np.bincount(self.owner, minlength=len(self.names)) == 2
        limbs = (figure.skeleton.limbs for figure in self.figures)
        return two & np.array([any(limb.kind == ARM for limb in own) for own in limbs], dtype=bool)

    @cached_property
    def first_leg(self) -> NDArray[np.int64]:
        """(C,) number of each creature's first leg."""
        return np.searchsorted(self.owner, np.arange(len(self.names)))

    @cached_property
    def legs_by_rank(self) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """Creatures and their first legs, then those with a second leg and that, and so on."""
        counts = np.bincount(self.owner, minlength=len(self.names))
        owners_of_rank = (np.flatnonzero(counts > k) for k in range(int(counts.max(initial=0))))
        return [(owners, self.first_leg[owners] + k) for k, owners in enumerate(owners_of_rank)]

    @cached_property
    def chains(self) -> list[ChainGroup]:
        """The legs, grouped by their kinds of joints."""
        return group_chains(self.legs, self.owner)

    @cached_property
    def soles(self) -> Array:
        """(L,) level lengths of the feet that stand on their soles, 0 for other legs [m]."""
        links = last_links(self.legs) if len(self.owner) else np.zeros((0, 3))
        has_sole = np.zeros(len(links), dtype=bool)
        for chain in self.chains:
            has_sole[chain.rows] = chain.foot is not None
        has_sole &= np.abs(slopes(links)) < LEVEL
        return np.where(has_sole, np.hypot(links[:, 0], links[:, 2]), 0.0)

    @property
    def hips(self) -> Array:
        """(L, 3) bases of the legs, relative to the body [m]."""
        return self.legs.places[:, 0]


def refuse_stiff_legs(where: str, member: Creature, figure: Figure, stiff: Sequence[Limb]) -> None:
    """Refuse to move a creature on legs that cannot shorten: a foot could not leave the ground.

    Raises:
        SceneError: it walks or hops, and there are such legs.
    """
    moves = [key for key in ("walk", "pronk") if getattr(member, key) is not None]
    if not stiff or not moves:
        return
    names = ", ".join(f"'{leg.name}'" for leg in stiff)
    message = (
        f"the legs of '{figure.name}' have to shorten, and {names} cannot: draw a knee, a node "
        f"between hip and foot; or take `{moves[0]}` away"
    )
    raise SceneError([Problem(f"{where}.{moves[0]}", message)])


def build_herd(cast: Sequence[tuple[int, Creature, Figure]], moods: Mapping[str, Mood]) -> Herd:
    """Collect creatures in one herd.

    Args:
        cast: place in the scene's cast, config and figure of each.
        moods: all known moods, by name.

    Raises:
        SceneError: if creatures cannot walk as configured; holds the problems of all.
    """
    owner, limbs = list[int](), []
    for c, (_, _, figure) in enumerate(cast):
        for limb in figure.skeleton.legs:
            owner.append(c)
            limbs.append((figure.skeleton, limb))
    legs = LimbBatch.of(limbs).slid_out()
    tips = legs.pose(legs.preferred).tips if limbs else np.zeros((0, 3))
    radii = np.array([limb.tip_radius for _, limb in limbs])
    owners = np.array(owner, dtype=np.int64)
    layouts, neutral, paces = list[LegLayout](), list[Pace](), list[Pace]()
    refusals = Refusals()
    stiff = ~bending_joints(legs).any(axis=1)
    for c, (number, member, figure) in enumerate(cast):
        own = owners == c
        with refusals.gathered():
            held = [limbs[i][1] for i in np.flatnonzero(own & stiff)]
            refuse_stiff_legs(f"cast[{number}]", member, figure, held)
        ends = radii[own] if own.sum() <= 2 else np.zeros(int(own.sum()))
        layouts.append(LegLayout(legs.places[own, 0], tips[own], legs.lengths[own], ends))
        with refusals.gathered():
            neutral.append(choose_pace(f"cast[{number}].walk", member.walk, figure, layouts[-1]))
            effect = blend_moods(member.mood, moods)
            paces.append(apply_mood(neutral[-1], effect, figure, layouts[-1]))
    refusals.refuse()
    spans = [
        np.abs(tips[owners == c][:, [0, 2]]).max(axis=0, initial=0.05) for c in range(len(cast))
    ]
    return Herd(
        names=tuple(member.name for _, member, _ in cast),
        figures=tuple(figure for _, _, figure in cast),
        starts=np.array([(member.at[0], member.at[-1]) for _, member, _ in cast], dtype=float),
        headings=np.radians([member.heading_deg for _, member, _ in cast]),
        leg_layouts=tuple(layouts),
        neutral_paces=tuple(neutral),
        paces=tuple(paces),
        cycle=np.array([p.cycle for p in paces]),
        stride=np.array([p.stride for p in paces]),
        body_height=np.array([p.body_height for p in paces]),
        bounciness=np.array([p.bounciness for p in paces]),
        lateral_offset=np.array([p.lateral_offset for p in paces]),
        running=np.array([p.running for p in paces]),
        beats=np.array([p.carrying.beats for p in paces], dtype=float),
        belly=np.array([figure.belly for _, _, figure in cast]),
        walks=np.array([member.walk is not None for _, member, _ in cast]),
        footprint=np.array(spans),
        owner=owners,
        leg_names=tuple(limb.name for _, limb in limbs),
        legs=legs,
        rest=tips[:, [0, 2]],
        up=np.concatenate([p.gait.up for p in paces]),
        down=np.concatenate([p.gait.down for p in paces]),
        step_height=np.array([paces[c].step_height for c in owner]),
        foot_radius=radii,
    )
