"""Frequencies of bodies against closed forms.

Source: Lamb 1882; Leissa 1969; Rayleigh 1877.
"""

import numpy as np
import pytest

from audio import elastic_modes
from audio.acoustic_materials import SOLIDS, shape_in_material
from audio.body_shape import BodyShape
from audio.elastic_modes import body_modes, membrane_modes
from audio.modal_synthesis import lowest_frequency
from audio.symmetric_eigen import lowest_eigenpairs
from audio.thin_walls import thin_walled_modes

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


def test_a_hollow_ball_has_the_modes_of_a_thin_shell():
    # Lamb 1882: Ω⁴ - (1 + 3ν + λ) Ω² + (λ - 2) (1 - ν²) = 0 with λ = n (n + 1).
    solid, shape = SOLIDS["metal"], BodyShape("ellipsoid", 0.2, 0.2, 0.2).hollow(0.004)
    nu, n = solid.poisson, np.array([2, 3, 4])
    b, c = 1 + 3 * nu + n * (n + 1), (n * (n + 1) - 2) * (1 - nu**2)
    squared = (b - np.sqrt(b * b - 4 * c)) / 2 / (1 - nu**2)
    expected = np.sqrt(squared * solid.young / solid.density) / 0.098 / (2 * np.pi)
    assert frequencies(shape, solid)[:3] == pytest.approx(expected, rel=0.05)


def test_walls_of_a_cube_that_move_outward_together_are_clamped_plates():
    # Leissa 1969: 35.99 for a clamped square, 19.74 for one with hinged edges.
    solid, shape = SOLIDS["metal"], BodyShape("box", 0.2, 0.2, 0.2).hollow(0.002)
    plate = np.sqrt(solid.young / (12 * (1 - solid.poisson**2)) / solid.density)
    unit = 0.002 * plate / 0.198**2 / (2 * np.pi)
    found = frequencies(shape, solid)
    assert found[np.abs(found - 35.99 * unit).argmin()] == pytest.approx(35.99 * unit, rel=0.03)
    # All others of one half wave lie between those of hinged and of clamped edges.
    assert 19.74 * unit < found[0] < 35.99 * unit


def test_walls_of_a_long_box_bend_as_hinged_plates():
    # Neighbours move against each other, and no edge keeps them from turning: π² (1 + (a / L)²).
    solid, shape = SOLIDS["oak"], BodyShape("box", 1.0, 0.2, 0.2).hollow(0.003)
    plate = np.sqrt(solid.young / (12 * (1 - solid.poisson**2)) / solid.density)
    expected = np.pi**2 * (1 + 0.2**2) * 0.003 * plate / 0.197**2 / (2 * np.pi)
    assert lowest_frequency(shape, solid) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(
    ("kind", "size", "wall"),
    [
        ("cylinder", (0.4, 0.2, 0.2), 0.008),
        ("cylinder", (0.4, 0.2, 0.2), 0.016),
    ],
)
def test_thin_walls_agree_with_elastic_solids_as_they_become_thick(monkeypatch, kind, size, wall):
    shape, poisson = BodyShape(kind, *size).hollow(wall), 0.3
    thin, _ = thin_walled_modes(kind, *shape.proportions, poisson)
    monkeypatch.setattr(elastic_modes, "THIN", 0.0)
    monkeypatch.setattr(elastic_modes, "_WALLED_DEGREE", 12)
    whole = elastic_modes._solved(kind, *shape.proportions, poisson)[:, 0]
    # Of polynomials, which are too stiff.
    assert 2 * thin.min() == pytest.approx(whole[0], rel=0.1)


def test_displacements_of_walls_have_a_mean_square_of_one():
    for kind, length, least, most in (("box", 0.2, 0.5, 1.5), ("cylinder", 0.8, 1.2, 1.8)):
        shape = BodyShape(kind, length, 0.2, 0.2).hollow(0.002)
        omega, seen = thin_walled_modes(kind, *shape.proportions, 0.3)
        # The blow is near the middle of a wall, where it moves more.
        lowest = np.sqrt((seen**2).mean(axis=1))[np.argsort(omega)[:8]]
        assert least < np.median(lowest) < most


def test_a_hollow_body_is_lower_and_lighter_than_a_solid_one():
    for kind in ("box", "cylinder", "ellipsoid"):
        solid = BodyShape(kind, 0.2, 0.2, 0.2)
        can = solid.hollow(0.003)
        assert can.volume < 0.15 * solid.volume
        assert lowest_frequency(can, SOLIDS["metal"]) < 0.5 * lowest_frequency(
            solid, SOLIDS["metal"]
        )
        assert solid.hollow(0.1) is solid
