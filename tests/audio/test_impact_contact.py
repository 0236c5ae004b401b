"""Impacts: duration of the contact, its spectrum, and the decay of what it excites."""

import numpy as np
import pytest

from audio.acoustic_materials import SOLIDS, solid_of
from audio.body_shape import BodyShape
from audio.impact_contact import contact_attenuation, contact_seconds, force_pulse
from audio.modal_synthesis import body_bank, lowest_frequency
from audio.synthesis import SoundParameters, synthesize

RATE = 48_000
STEEL = SOLIDS["metal"]


def blow(**changes):
    words = {
        "cause": "collision",
        "material": "oak",
        "surface": "steel",
        "speed": 1.0,
        "size": 0.3,
        "distance": 4.0,
        "pitch": 0.0,
        "decay": 0.0,
        "duration": 0.0,
        "variant": 0,
    }
    return synthesize(SoundParameters(**{**words, **changes}), 0)


def centroid(sound):
    power = np.abs(np.fft.rfft(sound, 1 << 16)) ** 2
    return float((np.fft.rfftfreq(1 << 16, 1 / RATE) * power).sum() / power.sum())


def test_the_duration_of_a_contact_is_that_of_hertz():
    # Two steel balls of 25 mm at 1 m/s touch for about 70 µs.
    mass = STEEL.density * np.pi / 6 * 0.025**3
    seconds = contact_seconds((STEEL, STEEL), 0.025 / 4, mass / 2, 1.0)
    assert seconds == pytest.approx(70e-6, rel=0.1)
    assert contact_seconds((STEEL, STEEL), 0.025 / 4, mass / 2, 16.0) == pytest.approx(
        seconds * 16**-0.2
    )


def test_a_force_has_unit_impulse_and_a_long_one_is_duller():
    for seconds in (1e-6, 1e-4, 5e-4, 1e-2):
        assert force_pulse(seconds).sum() == pytest.approx(1)
    f = np.array([100.0, 1000.0, 10_000.0])
    assert (contact_attenuation(f, 5e-4) == 1).all()
    left = contact_attenuation(f, 5e-3)
    assert left[0] > 0.5 > 0.1 > left[1] > left[2]


def test_a_blow_16_times_as_fast_is_brighter_as_hertz_says():
    mass, radius = 0.5, 0.02
    slow, fast = (
        centroid(force_pulse(contact_seconds((SOLIDS["oak"], STEEL), radius, mass, v)))
        for v in (0.25, 4.0)
    )
    assert fast / slow == pytest.approx(16**0.2, rel=0.05)


@pytest.mark.parametrize(("material", "surface"), [("oak", "oak"), ("ebony", "stone")])
def test_faster_blows_sound_brighter(material, surface):
    shape, solids = BodyShape("ellipsoid", 0.2, 0.2, 0.2), (solid_of(material), solid_of(surface))
    mass = shape.volume * solids[0].density
    slow, fast = (
        centroid(blow(material=material, surface=surface, contact=seconds, shape=shape))
        for seconds in (contact_seconds(solids, shape.contact_radius, mass, v) for v in (0.25, 4.0))
    )
    assert 1.1 < fast / slow < 2.2


@pytest.mark.parametrize(
    ("material", "shape"),
    [
        ("glass", BodyShape("vessel", 0.07, 0.1, 0.0015)),
        ("steel", BodyShape("box", 0.3, 0.02, 0.01)),
        ("porcelain", BodyShape("vessel", 0.08, 0.09, 0.004)),
    ],
)
def test_modes_decay_by_their_loss_factor(material, shape):
    solid = solid_of(material)
    f = lowest_frequency(shape, solid)
    sound = blow(material=material, shape=shape, surface="steel", spot=0.0)
    window = np.hanning(2400)

    def level(seconds):
        part = sound[int(seconds * RATE) :][: window.size]
        return abs((part * window * np.exp(-2j * np.pi * f / RATE * np.arange(part.size))).sum())

    # Air and the ground damp all modes alike.
    expected = np.pi * f * solid.loss + 1 + 160 * STEEL.loss
    first, second = 0.25, 0.25 + 1 / expected
    assert np.log(level(first) / level(second)) == pytest.approx(1, rel=0.2)


def test_a_steel_ball_clicks_and_a_steel_bar_rings():
    def audible(shape):
        bank = body_bank(shape, STEEL, 1.0, None, False, np.random.default_rng(0))
        return bank.seconds

    assert audible(BodyShape("ellipsoid", 0.1, 0.1, 0.1)) < 0.01
    assert audible(BodyShape("box", 0.3, 0.02, 0.01)) > 1


def test_woods_metals_and_porcelain_have_losses_of_their_own():
    assert 0.001 <= solid_of("white porcelain").loss <= 0.004
    assert solid_of("old brick").loss > solid_of("grey concrete").loss
    assert solid_of("brown leather").young != solid_of("skin").young
    assert len({solid_of(name).young for name in ("oak", "pine", "walnut", "ebony")}) == 4
