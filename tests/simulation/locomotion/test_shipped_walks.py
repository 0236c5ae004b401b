"""Invariants of walking in every shipped scene, at every step."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.spatial import Array
from pipeline.spec import find_scene, load_scene, shipped_scenes
from pipeline.spec.script import HopOver, JumpOnce
from tests.simulation.conftest import Walk, walk_through

MILLIMETRE = 1e-3

MAX_JOINT_SPEED = 40.0
"""Greatest speed of a leg's joint [rad/s]; a knee that a gallop stretches is at 36."""

MAX_BODY_ACCELERATION = 60.0
"""Greatest acceleration of a body [m/s²], about 6 g."""

BALL = np.random.default_rng(0).normal(size=(40, 3))
BALL /= np.linalg.norm(BALL, axis=-1, keepdims=True)


def is_walking_scene(name: str) -> bool:
    """Return whether creatures on legs walk over the ground of a scene, and none jumps."""
    scene = load_scene(find_scene(name))
    if any(isinstance(one.do, HopOver | JumpOnce) for one in scene.script):
        return False
    return any(
        member.walk is not None and member.figure != "inchworm" for _, member in scene.creatures
    )


def unposed_feet(walk: Walk) -> Array:
    """Return (K, L) which feet are left to their walk, not moved by an author."""
    times = np.arange(len(walk.phases)) * walk.simulation.world.clock.dt
    return walk.walkers.authored_poses.free_fraction(times) > 0.999


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.nightly if k % 2 else ())
        for k, name in enumerate(filter(is_walking_scene, shipped_scenes()))
    ],
)
def test_invariants_of_walking_hold_in_shipped_scenes(name: str) -> None:
    walk = walk_through(load_scene(find_scene(name)))
    take, herd, ground = walk.take, walk.walkers.herd, walk.simulation.world.ground
    dt, free = walk.simulation.world.clock.dt, unposed_feet(walk)
    assert [note for note in take.notes if "foothold" in note.text and note.kind != "stopped"] == []

    down = walk.standing[1:] & walk.standing[:-1] & free[1:]
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[down].max() < MILLIMETRE, "a foot slides"

    p = walk.tips[:, :, None] + herd.foot_radius[:, None, None] * BALL
    above = (p[..., 1] - ground.height(p[..., 0], p[..., 2])).min(axis=-1)
    assert above[free].min() > -MILLIMETRE, "a foot is below the ground"

    feet = [contact for contact in take.contacts if contact.kind in ("touch", "scuff")]
    x, y, z = np.array([contact.place for contact in feet]).T
    assert ground.steppable(x, z).all(), "a foothold is in a forbidden zone"
    assert np.abs(y - ground.height(x, z)).max() < 1e-9

    q = walk.q
    assert (q >= herd.legs.lower).all()
    assert (q <= herd.legs.upper).all()
    assert np.abs(np.diff(q, axis=0)).max() < MAX_JOINT_SPEED * dt, "a joint jumps"
    bodies = [take.nodes.index(n) for n in take.nodes if n.name.endswith(".body")]
    jerked = np.diff(take.positions[:, bodies], 2, axis=0) / dt**2
    assert np.linalg.norm(jerked, axis=-1).max() < MAX_BODY_ACCELERATION, "a body jumps"

    _keeps_its_phases(walk)
    for c in np.flatnonzero(herd.walks):
        own, pace = herd.owner == c, herd.paces[c]
        if pace.flight is None and c not in walk.walkers.progress.paces.changes:
            assert walk.standing[:, own].sum(axis=1).min() >= 1, "a walking creature flies"


def _keeps_its_phases(walk: Walk) -> None:
    """Feet come down when their gaits say so."""
    herd, paces = walk.walkers.herd, walk.walkers.progress.paces
    names = [f"{herd.names[c]}.{leg}" for leg, c in zip(herd.leg_names, herd.owner, strict=True)]
    # A hopper has no phases.
    touches = [c for c in walk.take.contacts if c.kind == "touch" and c.part in names]
    assert touches
    for contact in touches:
        leg = names.index(contact.part)
        before, after = (float(walk.phases[contact.step + k][herd.owner[leg]]) for k in (0, 1))
        phase = before + contact.fraction * (after - before)
        planned = paces.stances(leg, phase - 0.5, phase + 0.5)[:, 0]
        assert np.abs(planned - phase).min() < 1e-6, contact
