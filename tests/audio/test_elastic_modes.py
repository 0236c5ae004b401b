"""Frequencies of bodies against closed forms.

Source: Lamb 1882; Leissa 1969; Rayleigh 1877.
"""

import numpy as np
import pytest

from audio.acoustic_materials import SOLIDS, shape_in_material
from audio.body_shape import BodyShape
from audio.elastic_modes import body_modes, membrane_modes
from audio.modal_synthesis import lowest_frequency
from audio.symmetric_eigen import lowest_eigenpairs

BENDING = np.array([4.730041, 7.853205, 10.995608])
"""Roots of cos β cosh β = 1: a bar free at both ends."""


def frequencies(shape, solid):
    modes = body_modes(shape.kind, *shape.proportions, solid.poisson)
    return modes.omega * np.sqrt(solid.young / solid.density) / shape.length / (2 * np.pi)


def thin(shape, solid):
    """Return sqrt(D / (ρ h)) of a plate [m²/s]."""
    stiffness = solid.young / (12 * (1 - solid.poisson**2))
    return shape.thickness * np.sqrt(stiffness / solid.density)


@pytest.mark.parametrize(
    ("material", "size"),
    [("metal", (0.3, 0.02, 0.01)), ("oak", (1.0, 0.1, 0.02)), ("oak", (0.4, 0.05, 0.004))],
)
def test_bars_and_planks_bend_as_euler_and_bernoulli_say(material, size):
    shape, solid = BodyShape("box", *size), SOLIDS[material]
    speed = np.sqrt(solid.young / solid.density)
    expected = BENDING**2 * speed * size[2] / np.sqrt(12) / (2 * np.pi * size[0] ** 2)
    found = frequencies(shape, solid)
    nearest = [found[np.abs(found - f).argmin()] for f in expected]
    assert nearest == pytest.approx(expected, rel=0.1)
    assert found[0] == pytest.approx(expected[0], rel=0.05)


def test_size_and_thickness_set_the_pitch_of_a_plank():
    planks = [BodyShape("box", 20 * t, 2 * t, t) for t in (0.01, 0.05, 0.2)]
    pitches = [lowest_frequency(plank, SOLIDS["oak"]) for plank in planks]
    assert pitches[0] / pitches[1] == pytest.approx(5)
    assert pitches[0] / pitches[2] == pytest.approx(20)


def test_a_square_glass_plate_has_the_modes_of_leissa():
    # For ν = 0.3; the lowest, a twist, is √((1 - ν) / (1 - 0.3)) as high.
    solid, shape = SOLIDS["glass"], BodyShape("box", 0.3, 0.3, 0.004)
    expected = np.array([13.49, 19.79, 24.43, 35.02]) / (2 * np.pi * 0.09) * thin(shape, solid)
    expected[0] *= np.sqrt((1 - solid.poisson) / 0.7)
    assert frequencies(shape, solid)[:4] == pytest.approx(expected, rel=0.05)


def test_a_disc_has_the_modes_of_leissa():
    solid, shape = SOLIDS["metal"], BodyShape("cylinder", 0.3, 0.3, 0.004)
    expected = np.array([5.25, 9.08, 12.2]) / (2 * np.pi * 0.15**2) * thin(shape, solid)
    assert frequencies(shape, solid)[:3] == pytest.approx(expected, rel=0.05)


def test_a_steel_ball_rings_above_hearing_as_lamb_says():
    # Lamb's lowest spheroidal mode: ω a / c_s = 2.64 for ν = 0.29; torsional 2.501.
    solid, shape = SOLIDS["metal"], BodyShape("ellipsoid", 0.1, 0.1, 0.1)
    shear_speed = np.sqrt(solid.young / (2 * (1 + solid.poisson)) / solid.density)
    expected = np.array([2.501, 2.64]) * shear_speed / 0.05 / (2 * np.pi)
    assert frequencies(shape, solid)[:2] == pytest.approx(expected, rel=0.02)
    assert expected.min() > 20_000


@pytest.mark.parametrize(
    ("material", "size"), [("glass", (0.07, 0.1, 0.0015)), ("porcelain", (0.08, 0.09, 0.004))]
)
def test_glasses_and_cups_ring_as_rayleigh_says(material, size):
    # A wall that moves in proportion to its height and bends without stretching, two waves around.
    solid, shape = SOLIDS[material], BodyShape("vessel", *size)
    radius, wall, height = (size[0] - size[2]) / 2, size[2], size[1]
    ring = np.sqrt(0.6 * solid.young / (1 - solid.poisson**2) / solid.density) * wall / radius**2
    slope = (radius / height) ** 2
    stiffer = (1 + 1.5 * (1 - solid.poisson) * slope) / (1 + 0.15 * slope)
    assert frequencies(shape, solid)[0] == pytest.approx(
        ring * np.sqrt(stiffer) / (2 * np.pi), rel=0.1
    )


def test_a_drum_has_the_zeros_of_bessel_functions():
    solid, shape = SOLIDS["drumhead"], BodyShape("membrane", 0.33, 0.33, 0.00025)
    ratios = membrane_modes().omega / membrane_modes().omega[0]
    assert ratios[:5] == pytest.approx([1, 1.593, 2.136, 2.295, 2.653], abs=1e-3)
    speed = np.sqrt(solid.young / solid.density)
    assert lowest_frequency(shape, solid) == pytest.approx(
        2.4048 * speed / (np.pi * 0.33), rel=1e-4
    )


def test_round_and_upright_glass_is_a_vessel_and_a_disc_or_rod_is_not():
    def kind(length, width, thickness):
        return shape_in_material("glass", BodyShape("cylinder", length, width, thickness)).kind

    assert kind(0.1, 0.08, 0.08) == "vessel"
    assert kind(0.08, 0.08, 0.06) == "vessel"
    assert kind(0.3, 0.3, 0.01) == kind(0.3, 0.02, 0.02) == "cylinder"
    cup = shape_in_material("porcelain", BodyShape("cylinder", 0.1, 0.08, 0.08))
    assert (cup.length, cup.width) == (0.08, 0.1)


def test_eigenpairs_leave_out_dependent_directions():
    rng = np.random.default_rng(1)
    T = rng.normal(size=(12, 9))
    stiffness = np.diag(np.arange(1.0, 10))
    # Nine directions, seen by twelve that depend on each other.
    values, vectors = lowest_eigenpairs(T @ stiffness @ T.T, T @ T.T, 4)
    assert values == pytest.approx([1, 2, 3, 4])
    assert vectors.T @ T @ T.T @ vectors == pytest.approx(np.eye(4), abs=1e-8)
