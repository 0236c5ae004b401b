"""Scuffs: once a swing, where the foot rubs most, at the same time at every frame rate."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from pipeline.simulation.locomotion.swing.foot_contacts import (
    DRAGGED_MASS,
    MID_SWING,
    MIN_SCUFF_SPEED,
    SCUFF_DISTANCE,
    scuff_at_touchdown,
    scuff_in_swing,
)
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import SoundEvent, Take
from pipeline.simulation.take_store import read_take, write_take
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec import Scene, read_scene

ROUGH = "{kind: fractal, height: 0.3, size: [20, 20]}"
FIGURES = ("person", "horse", "beetle")


def scene(figure: str, step: str, terrain: str = ROUGH, fps: str = "24") -> Scene:
    speed = 0.7 if figure == "beetle" else 0.8
    walk = f"{{step_height: {step}, speed: {speed}}}" if step else "{}"
    return read_scene(
        f"pronk: 1\nfps: {fps}\nduration: 4\nseed: 1\nterrain: {terrain}\n"
        f"cast: [{{figure: {figure}, walk: {walk}}}]\n"
    )


def scuffs_of(take: Take) -> list[SoundEvent]:
    return [event for event in take.events if event.cause == "scuff"]


def times(take: Take) -> Array:
    rate = take.header.rate * take.header.steps
    return np.array([float((e.step + Fraction(e.fraction)) / rate) for e in scuffs_of(take)])


def plane(slope: float) -> Ground:
    """Return ground of constant slope along x."""
    heights = np.tile(slope * np.linspace(-5.0, 5.0, 11), (11, 1))
    return Ground(HeightField(heights, (10.0, 10.0)), np.zeros((10, 10), dtype=bool), "rock")


@pytest.fixture(scope="module", params=FIGURES)
def dragging(request: pytest.FixtureRequest, walk_through: Callable[..., object]) -> object:
    """Return walks on rough ground with barely lifted feet."""
    return walk_through(scene(request.param, "0.004"))


def test_foot_scuffs_at_most_once_a_swing(dragging: object) -> None:
    """Swings are counted by recorded feet in the air."""
    assert len(scuffs_of(dragging.take)) > 5
    swings = np.cumsum(np.diff(np.array(dragging.swinging).astype(int), axis=0) == 1, axis=0)
    herd = dragging.walkers.herd
    names = [f"{herd.names[c]}.{leg}" for leg, c in zip(herd.leg_names, herd.owner, strict=True)]
    heard = Counter()
    for event in scuffs_of(dragging.take):
        leg = names.index(event.part)
        assert dragging.swinging[event.step + 1][leg]
        heard[leg, swings[event.step, leg]] += 1
    assert max(heard.values()) == 1


def test_scuff_has_place_and_speed_of_the_foot(dragging: object) -> None:
    take, herd = dragging.take, dragging.walkers.herd
    ground = dragging.simulation.world.ground
    names = [f"{herd.names[c]}.{leg}" for leg, c in zip(herd.leg_names, herd.owner, strict=True)]
    rate = float(take.header.rate * take.header.steps)
    for event, contact in zip(
        scuffs_of(take), (c for c in take.contacts if c.kind == "scuff"), strict=True
    ):
        leg = names.index(event.part)
        place, normal = np.array(event.place), np.array(contact.normal)
        assert place[1] == pytest.approx(float(ground.height(place[0], place[2])), abs=1e-12)
        before, after = dragging.tips[event.step : event.step + 2, leg]
        tip = before + event.fraction * (after - before)
        # An accelerating foot leaves the chord between two rows.
        assert np.hypot(*(tip - place)[[0, 2]]) < 0.01 * herd.legs.lengths[leg]
        assert (tip - place) @ normal - herd.foot_radius[
            leg
        ] < 1.2 * SCUFF_DISTANCE * herd.legs.lengths[leg]
        # Its speed is known in the middle of each step, from the chords.
        chords = np.diff(dragging.tips[event.step - 1 : event.step + 3, leg], axis=0) * rate
        chords -= (chords @ normal)[:, None] * normal
        speeds = np.linalg.norm(chords, axis=-1)
        now = float(np.interp(event.fraction + 0.5, [0.0, 1.0, 2.0], speeds))
        assert event.strength == pytest.approx(now, rel=0.05)
        assert event.strength >= MIN_SCUFF_SPEED * herd.legs.lengths[leg]
        most = (
            0.5 * DRAGGED_MASS * dragging.walkers.sequencer.contacts.mass[leg] * event.strength**2
        )
        assert 0.0 < event.energy <= most * (1.0 + 1e-12)


@pytest.mark.parametrize("figure", FIGURES)
def test_normal_steps_do_not_scuff(figure: str) -> None:
    take = simulate(scene(figure, ""))
    assert not scuffs_of(take)
    assert {contact.kind for contact in take.contacts} == {"touch"}


@pytest.mark.nightly
@pytest.mark.parametrize("step", ["0.004", pytest.param("0.02", marks=pytest.mark.nightly)])
def test_frame_rate_does_not_change_scuffs(step: str) -> None:
    film = simulate(scene("beetle", step, "flat"))
    for fps in ("25", "'30000/1001'", "60"):
        other = simulate(scene("beetle", step, "flat", fps))
        n = min(len(scuffs_of(film)), len(scuffs_of(other)))
        assert n > 15
        assert np.abs(times(film)[:n] - times(other)[:n]).max() < 1e-9
    # Slopes are sampled at steps, and two bumps of a swing may be nearly equal.
    rough, other = (simulate(scene("beetle", step, ROUGH, fps)) for fps in ("24", "60"))
    n = min(len(scuffs_of(rough)), len(scuffs_of(other)))
    assert (np.abs(times(rough)[:n] - times(other)[:n]) < 1e-4).mean() > 0.9


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_scuff_over_a_plane(slope: float) -> None:
    """The strength grows with the speed along the plane and with the depth."""
    down = np.hypot(1.0, slope)
    x = np.linspace(-0.2, 0.2, len(MID_SWING))
    normal = np.array([-slope, 1.0, 0.0]) / down

    def swing_with_gap(gap: float) -> Array:
        path = np.stack([x, slope * x, np.zeros_like(x)], axis=-1)
        return path + (0.03 + gap) * normal

    for gap, weight in ((0.0, DRAGGED_MASS), (0.005, 0.5 * DRAGGED_MASS), (-0.01, DRAGGED_MASS)):
        scuff = scuff_in_swing(plane(slope), swing_with_gap(gap), MID_SWING, 0.03, 0.01)
        assert scuff is not None
        assert scuff.slide == pytest.approx(0.4 * down / 0.5)
        assert scuff.mass_fraction == pytest.approx(weight)
        assert scuff.normal == pytest.approx(normal)
    assert scuff_in_swing(plane(slope), swing_with_gap(0.0101), MID_SWING, 0.03, 0.01) is None


def test_scuff_is_at_the_bump() -> None:
    heights = np.zeros((3, 41))
    heights[:, 26] = 0.05
    ground = Ground(HeightField(heights, (0.4, 1.0)), np.zeros((2, 40), dtype=bool), "rock")
    tips = np.stack([np.linspace(-0.2, 0.2, 65), np.full(65, 0.065), np.zeros(65)], axis=-1)
    scuff = scuff_in_swing(ground, tips, MID_SWING, 0.0, 0.02)
    assert scuff is not None
    assert scuff.place[0] == pytest.approx(0.06, abs=0.4 / 64)


def test_scuff_of_a_foot_that_slides_at_touchdown() -> None:
    tips = np.array([[0.0, 0.01, 0.0], [0.006, 0.0, 0.008]])
    scuff = scuff_at_touchdown(tips, np.array([0.99, 1.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]))
    assert scuff.slide == pytest.approx(1.0)
    assert scuff.fraction == 1.0


def test_take_stores_scuffs(dragging: object, tmp_path: Path) -> None:
    take = dragging.take
    write_take(take, tmp_path / "take.zarr")
    again = read_take(tmp_path / "take.zarr")
    assert again.contacts == take.contacts
    assert again.digest == take.digest
    # A touch has the columns of contacts without scuffs.
    lengths = {
        c.kind: len(row) for c, row in zip(take.contacts, take.tables()["contacts"], strict=True)
    }
    assert lengths == {"touch": 12, "scuff": 13}
    plain = replace(take, contacts=tuple(c for c in take.contacts if c.kind == "touch"))
    assert plain.digest != take.digest


def test_feet_that_do_not_come_to_rest_scuff_at_touchdown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Return a swing of constant speed from foothold to foothold."""

    def even(start: Array, end: Array, height: Array, s: Array, bend: object = None) -> Array:
        return start + s[:, None] * (end - start)

    monkeypatch.setattr("pipeline.simulation.locomotion.swing.foot_contacts.swing_positions", even)
    take = simulate(scene("beetle", "", "flat"))
    touches = [c for c in take.contacts if c.kind == "touch"]
    scuffs = [c for c in take.contacts if c.kind == "scuff"]
    assert len(scuffs) > 10
    moments = {(c.part, c.step, c.fraction): c for c in touches}
    for scuff in scuffs:
        assert scuff.place == moments[scuff.part, scuff.step, scuff.fraction].place
    assert len({(c.part, c.step) for c in scuffs}) == len(scuffs)
