"""Invariants of every walk at every step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH

if TYPE_CHECKING:
    from tests.simulation.conftest import Walk

MILLIMETRE = 1e-3


@pytest.mark.slow
def test_standing_feet_do_not_slip(walk: Walk) -> None:
    down = walk.standing[1:] & walk.standing[:-1]
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[down].max() < 0.1 * MILLIMETRE


@pytest.mark.slow
def test_standing_feet_are_on_their_footholds(walk: Walk) -> None:
    ends = np.array(walk.ends)[walk.standing]
    assert np.abs(walk.tips[walk.standing] - ends).max() < 0.1 * MILLIMETRE
    assert not [note for note in walk.take.notes if note.kind == "clamped"]


def test_no_sole_is_below_the_ground(walk: Walk) -> None:
    ground, herd = walk.simulation.world.ground, walk.walkers.herd
    x, y, z = np.moveaxis(walk.tips, -1, 0)
    rng = np.random.default_rng(0).normal(size=(40, 3))
    ball = rng / np.linalg.norm(rng, axis=-1, keepdims=True)
    p = walk.tips[:, :, None] + herd.foot_radius[:, None, None] * ball
    above = p[..., 1] - ground.height(p[..., 0], p[..., 2])
    assert above.min() > -MILLIMETRE
    assert (y > ground.height(x, z)).all()
    near = y - herd.foot_radius / ground.normal(x, z)[..., 1] - ground.height(x, z)
    assert np.abs(near[walk.standing]).max() < 4 * MILLIMETRE


def test_feet_clear_the_ground_between_footholds(walk: Walk) -> None:
    ground, herd = walk.simulation.world.ground, walk.walkers.herd
    phases, lifted = np.array(walk.phases)[:, herd.owner], np.array(walk.lifted)
    s = (phases - lifted) / np.mod(herd.down - herd.up, 1.0)
    middle = ~walk.standing & (np.abs(s - 0.5) < 0.15)
    x, y, z = np.moveaxis(walk.tips, -1, 0)
    clear = y - ground.height(x, z) - herd.foot_radius
    assert middle.any()
    assert (clear >= 0.3 * herd.step_height)[middle].all()


def test_no_foothold_is_in_a_forbidden_zone(walk: Walk) -> None:
    ground = walk.simulation.world.ground
    places = np.array([contact.place for contact in walk.take.contacts])
    assert ground.steppable(places[:, 0], places[:, 2]).all()
    assert np.allclose(places[:, 1], ground.height(places[:, 0], places[:, 2]), atol=1e-12)
    holds = np.array([hold.place for hold in walk.walkers.sequencer.feet.footholds])
    assert ground.steppable(holds[:, 0], holds[:, 2]).all()


def test_joints_keep_their_limits(walk: Walk) -> None:
    legs, q = walk.walkers.herd.legs, np.array(walk.q)
    assert (q >= legs.lower).all()
    assert (q <= legs.upper).all()


def test_knees_never_flip(walk: Walk) -> None:
    q = np.array(walk.q)
    knees = [
        q[:, i, k]
        for i, leg in enumerate(_legs(walk))
        for k, name in enumerate(leg)
        if name.endswith("bend")
    ]
    assert len(knees) == 2 * q.shape[1]
    assert np.max(knees) < 0.0


def test_joint_speeds_are_bounded(walk: Walk) -> None:
    """The bound of 20 rad/s is the speed of an insect's twitch."""
    dt = walk.simulation.world.clock.dt
    assert np.abs(np.diff(np.array(walk.q), axis=0)).max() < 20.0 * dt


@pytest.mark.slow
def test_body_acceleration_is_bounded(walk: Walk) -> None:
    body = walk.take.positions[:, 0]
    dt = walk.simulation.world.clock.dt
    acceleration = np.diff(body, 2, axis=0) / dt**2
    assert np.abs(acceleration).max() < 40.0


def test_tripod_gait_always_has_three_feet_down(walk: Walk) -> None:
    herd = walk.walkers.herd
    fewest = walk.standing.sum(axis=1).min()
    assert fewest >= (3 if herd.beats[0] == 2 and len(herd.up) == 6 else 1)


def test_contacts_are_at_foot_down_phases(walk: Walk) -> None:
    herd = walk.walkers.herd
    names = [f"{herd.names[c]}.{leg}" for leg, c in zip(herd.leg_names, herd.owner, strict=True)]
    assert walk.take.contacts
    for contact in walk.take.contacts:
        leg = names.index(contact.part)
        # Slopes slow a creature; within a step its phase grows evenly.
        before, after = (walk.phases[contact.step + k][herd.owner[leg]] for k in (0, 1))
        off = before + contact.fraction * (after - before) - herd.down[leg]
        assert abs(off - round(off)) < 1e-9


def test_every_footfall_sounds_once(walk: Walk) -> None:
    """Touchdowns are found from the poses alone."""
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1) > 5e-6
    stopped = (moved[:-1] & ~moved[1:]).sum()
    # Feet that land within the last step have no row at rest.
    late = sum(c.step >= len(walk.tips) - 2 for c in walk.take.contacts)
    assert abs(len(walk.take.contacts) - late - stopped) <= 1
    loud = [event for event in walk.take.events if event.cause == "footfall"]
    keys = [(event.part, event.step) for event in loud]
    assert len(keys) == len(set(keys))
    assert len(loud) == sum(contact.speed >= 0.005 for contact in walk.take.contacts)


def test_belly_stays_near_or_above_the_ground(walk: Walk) -> None:
    """The body follows a smoothed ground, so a corner may graze it."""
    ground, figure = walk.simulation.world.ground, walk.walkers.herd.figures[0]
    recorder = walk.simulation.recorder
    tall = float(walk.walkers.herd.body_height[0])
    for row in range(0, len(recorder.positions), 7):
        v = figure.body.vertices @ recorder.rotations[row, 0].T + recorder.positions[row, 0]
        assert (v[:, 1] - ground.height(v[:, 0], v[:, 2])).min() > -0.3 * tall


def test_the_shipped_beetle_keeps_its_belly_clear(first_steps: Walk) -> None:
    ground, figure = (
        first_steps.simulation.world.ground,
        first_steps.walkers.herd.figures[0],
    )
    recorder = first_steps.simulation.recorder
    for row in range(0, len(recorder.positions), 3):
        v = figure.body.vertices @ recorder.rotations[row, 0].T + recorder.positions[row, 0]
        assert (v[:, 1] - ground.height(v[:, 0], v[:, 2])).min() > -0.005


def test_no_leg_is_overstretched(walk: Walk) -> None:
    herd, recorder = walk.walkers.herd, walk.simulation.recorder
    R, p = recorder.rotations[:, 0, None], recorder.positions[:, 0, None]
    hips = p + (R @ herd.hips[..., None])[..., 0]
    stretch = np.linalg.norm(walk.tips - hips, axis=-1) / herd.legs.lengths
    assert stretch.max() < MAX_REACH + 0.005


def test_take_is_finite_and_rotations_are_unit_quaternions(walk: Walk) -> None:
    take = walk.take
    for _, values in take.arrays():
        assert np.isfinite(values).all()
    assert np.allclose(np.linalg.norm(take.rotations, axis=-1), 1.0, atol=1e-12)
    assert (np.sum(take.rotations[1:] * take.rotations[:-1], axis=-1) > 0.9).all()
    assert (take.meshes[0].faces < len(take.meshes[0].vertices)).all()


def test_links_keep_their_lengths(walk: Walk) -> None:
    """Each link of a leg starts at the end of the one before."""
    figure, recorder = walk.walkers.herd.figures[0], walk.simulation.recorder
    links = figure.skeleton.links
    for limb in figure.skeleton.legs:
        for a, b in zip(limb.links[:-1], limb.links[1:], strict=True):
            R, p = recorder.rotations[:, a], recorder.positions[:, a]
            end = p + R @ (links[a].ends[1] - links[a].ends[0])
            assert np.allclose(end, recorder.positions[:, b], atol=1e-9)


def test_nodes_have_their_parents(walk: Walk) -> None:
    nodes = walk.take.nodes
    assert [n.parent for n in nodes].count(-1) == 1
    assert nodes[0].parent == -1
    for number, node in enumerate(nodes[1:], start=1):
        assert 0 <= node.parent < number
        stem, index = node.name.rsplit(".", 1)
        if int(index) > 1:
            assert nodes[node.parent].name == f"{stem}.{int(index) - 1}"


def _legs(walk: Walk) -> list[list[str]]:
    skeleton = walk.walkers.herd.figures[0].skeleton
    assert (skeleton.parents >= BODY).all()
    return [[skeleton.joint_names[j] for j in leg.joints] for leg in skeleton.legs]
