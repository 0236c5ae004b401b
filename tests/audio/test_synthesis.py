"""Synthesis: loudness, spectrum, pitch and decay of single sounds."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from audio.acoustic_materials import FAMILIES, usual_shape
from audio.struck_body import BLOWS, Blow

BY_DAY = ("wood", "metal", "cloth", "gravel")
"""Materials of every kind of sound; the others are nightly."""


def centroid(sound):
    """Return the mean frequency of the power of both sides [Hz]."""
    power = np.abs(np.fft.rfft(sound.sum(axis=1))) ** 2
    return float((np.fft.rfftfreq(len(sound), 1 / 48_000) * power).sum() / power.sum())


def db(level):
    return 20 * np.log10(level)


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    "material",
    [
        name if name in BY_DAY else pytest.param(name, marks=pytest.mark.nightly)
        for name in sorted(FAMILIES)
    ],
)
def test_every_material_pair_starts_at_once_and_decays(step, render, material):
    for surface in FAMILIES:
        sound = render([step(2, material=material, surface=surface)], 24 * 8, 24)
        loudest = np.abs(sound).max()
        assert not sound[:2000].any()
        assert np.abs(sound[2000]).min() > 0.002 * loudest
        assert not sound[-48:].any()
        # No constant pressure: the mean is far below the peak.
        assert np.abs(sound.mean(axis=0)).max() < 1e-5


def test_the_last_bits_of_time_and_size_vary_nothing(step, render):
    # They differ between classes of processor.
    event = step(2, size=0.123456789012, time=Fraction(1, 30))
    other = replace(event, size=event.size * (1 + 2e-16), time=event.time - Fraction(1, 10**16))
    assert np.allclose(render([event], 24), render([other], 24), atol=1e-9)


def test_seed_and_time_vary_an_impact_slightly(step, render):
    def blow(frame, seed):
        blow = step(frame, cause="collision", surface="stone")
        sound = render([blow], 24, seed=seed)
        return sound[2000 * (frame - 1) :][:8000]

    first, reseeded, later = blow(1, 0), blow(1, 1), blow(3, 0)
    for other in (reseeded, later):
        assert np.abs(first - other).max() > 0.05 * np.abs(first).max()
        assert abs(db(np.abs(first).max() / np.abs(other).max())) < 2
        assert 0.5 < centroid(first) / centroid(other) < 2


@pytest.mark.parametrize(
    ("field", "values"),
    [("strength", (0.05, 0.2, 1.0)), ("distance", (24, 8, 3)), ("energy", (0.02, 0.2, 2))],
)
def test_stronger_nearer_and_heavier_is_louder(step, render, field, values):
    peaks = [np.abs(render([step(1, **{field: value})])).max() for value in values]
    assert peaks == sorted(set(peaks))


def test_twice_the_distance_is_6_db_softer(step, render):
    near, far = (np.abs(render([step(1, distance=d)])).max() for d in (3, 6))
    assert db(near / far) == pytest.approx(6.02, abs=0.01)


def test_distance_dulls_and_small_size_brightens(step, render):
    def brightness(**changes):
        # Averaged over variants.
        blows = (
            render([step(f, cause="collision", surface="rock", **changes)], 48) for f in range(1, 9)
        )
        return np.mean([centroid(blow) for blow in blows])

    assert brightness(distance=400) < 0.9 * brightness(distance=4)
    small, middle, large = (brightness(size=size) for size in (0.02, 0.1, 0.6))
    assert small > 1.2 * middle > 1.4 * large


@pytest.mark.slow
@pytest.mark.parametrize(
    ("brighter", "duller"),
    [("rock", "dry soil"), ("sand", "snow"), ("glass", "wood"), ("gravel", "mud")],
)
def test_grounds_differ_in_brightness(step, render, brighter, duller):
    bright, dull = (
        np.mean(
            [centroid(render([step(f, cause="collision", surface=ground)])) for f in range(1, 9)]
        )
        for ground in (brighter, duller)
    )
    assert bright > 1.25 * dull


@pytest.mark.nightly
def test_every_pair_of_materials_has_its_own_spectrum(step, render):
    # Third-octave levels of successive blocks, averaged over variants.
    edges = 100 * 2 ** (np.arange(22) / 3)
    bands = {}
    for name in FAMILIES:
        power = 0
        for frame in (1, 3, 5, 7):
            event = step(frame, cause="collision", material=name, surface="concrete", size=0.1)
            sound = render([event], 96)
            spectrum = np.abs(np.fft.rfft(sound[:, 0])) ** 2
            power = (
                power
                + np.histogram(np.fft.rfftfreq(len(sound), 1 / 48_000), edges, weights=spectrum)[0]
            )
        bands[name] = 10 * np.log10(power / power.sum() + 1e-6)
    names = sorted(bands)
    distance = {
        (a, b): np.sqrt(np.mean((bands[a] - bands[b]) ** 2))
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    }
    assert min(distance.values()) > 1.0, min(distance, key=distance.get)


def test_metal_rings_longer_than_wood_and_wood_longer_than_rubber():
    # By themselves: the ground rings as long as wood.
    def ringing(material):
        blow = Blow(material, "concrete", usual_shape(material, 0.1), 1e-4, 4.0, 0)
        energy = np.cumsum(BLOWS.sound(blow, 0) ** 2)
        return int(np.searchsorted(energy, 0.999 * energy[-1]))

    metal, wood, rubber = map(ringing, ("steel", "oak", "rubber"))
    assert metal > 3 * wood > 6 * rubber


def test_a_configured_pitch_tunes_the_ring(step, render):
    for pitch, hertz in ((57, 220.0), (81, 880.0)):
        sound = render(
            [step(1, material="steel", surface="steel")],
            96,
            sound={"voices": [{"pitch": pitch}]},
        )
        spectrum = np.abs(np.fft.rfft(sound[:, 0]))
        f = np.fft.rfftfreq(len(sound), 1 / 48_000)
        near = (f > hertz / 1.3) & (f < hertz * 1.12)
        assert f[near][spectrum[near].argmax()] == pytest.approx(hertz, rel=0.01)


def test_a_configured_length_ends_the_ring(step, render):
    def ringing(length):
        sound = render(
            [step(1, material="steel", surface="steel")],
            24 * 8,
            sound={"voices": [{"length": length}]},
        )
        return np.flatnonzero(np.abs(sound[:, 0]) > np.abs(sound).max() / 1000)[-1] / 48_000

    assert 0.02 < ringing(0.1) < 0.15
    assert 1 < ringing(3.0) < 4


@pytest.mark.parametrize(
    "cause",
    [
        *("swoosh", "whistle", "squeak", "squawk", "boing", "push off", "breath", "cry"),
        *("laugh", "gasp", "call", "growl", "whine", "wings", "rustle"),
    ],
)
def test_motion_sounds_start_on_their_frame_and_have_their_duration(step, render, cause):
    sound = render([step(3, cause=cause, duration=0.5, strength=3.0)], 48)
    loud = np.flatnonzero(np.abs(sound).max(axis=1) > np.abs(sound).max() / 300)
    assert not sound[:4000].any()
    assert sound[4000:4048].any()
    assert 0.3 < (loud[-1] - 4000) / 48_000 <= 0.5
    assert not sound[4000 + 24_001 :].any()


def test_a_cry_is_higher_for_a_child_and_a_hug_is_dull(step, render):
    def tone(size, strength=3.0):
        sound = render([step(1, cause="cry", size=size, strength=strength)], 24).sum(axis=1)
        # The lag of the greatest autocorrelation in its loudest part.
        part = sound[6000:14_000]
        like = np.correlate(part, part, "full")[len(part) - 1 :]
        lags = np.arange(60, 320)
        best = lags[np.argmax(like[lags])]
        return 48_000 / best, like[best] / like[0]

    (child, periodic), (adult, _) = tone(0.11), tone(0.17)
    assert 350 < child < 600
    assert 0.65 * child < adult < 0.95 * child
    assert periodic > 0.7
    cry, hug = (render([step(1, cause=c, size=0.15, strength=1.0)], 24) for c in ("cry", "hug"))
    assert centroid(cry) > 4 * centroid(hug)


def test_a_roll_has_its_duration(step, render):
    sound = render([step(3, cause="roll", duration=1.0, material="wood")], 48)
    assert np.abs(sound[4000]).min() > 1e-6
    middle, late = (np.sqrt((sound[a : a + 4800] ** 2).mean()) for a in (20_000, 45_000))
    assert abs(db(middle / late)) < 3
    assert not sound[4000 + 48_001 :].any()


def test_a_scuff_starts_on_its_frame_and_is_short_and_soft(step, render):
    scuff, blow = (
        render([step(3, cause=cause, surface="gravel")], 48) for cause in ("scuff", "footfall")
    )
    assert not scuff[:4000].any()
    assert scuff[4000:4048].any()
    loud = np.flatnonzero(np.abs(scuff).max(axis=1) > np.abs(scuff).max() / 300)
    assert 0.08 < (loud[-1] - 4000) / 48_000 <= 0.14
    assert db(np.abs(scuff).max() / np.abs(blow).max()) == pytest.approx(-12, abs=1.7)


@pytest.mark.parametrize(("coarse", "fine"), [("gravel", "mud"), ("rock", "dry soil")])
def test_a_scuff_is_as_bright_as_its_ground(step, render, coarse, fine):
    bright, dull = (centroid(render([step(3, cause="scuff", surface=s)])) for s in (coarse, fine))
    assert bright > 1.1 * dull
