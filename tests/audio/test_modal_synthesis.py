"""Mode shapes against closed forms, and the effect of the point of impact."""

import numpy as np
import pytest
from scipy.special import jv

from audio.acoustic_materials import solid_of
from audio.body_shape import BodyShape
from audio.modal_synthesis import lowest_frequency
from audio.mode_shapes import BAR, BELL, MEMBRANE, PLATE, SHELL
from audio.wav_file import write_wav

ALL = {"bar": BAR, "plate": PLATE, "bell": BELL, "membrane": MEMBRANE, "shell": SHELL}
X = (np.arange(2000) + 0.5) / 2000


@pytest.mark.parametrize("name", sorted(ALL))
def test_every_mode_shape_has_a_maximum_of_one(name):
    shape = ALL[name]
    moves = np.array([shape.displacement(x, 0.0) for x in np.linspace(0, 1, 401)])
    assert moves.shape == (401, len(shape.ratios))
    assert np.abs(moves).max(axis=0) == pytest.approx(1, abs=0.01)


def test_the_modes_of_a_free_bar_are_orthogonal_and_keep_both_momenta_zero():
    moves = np.array([BAR.displacement(x, 0.0) for x in X])
    products = moves.T @ moves / X.size
    assert products == pytest.approx(0.25 * np.eye(6), abs=1e-3)
    assert moves.mean(axis=0) == pytest.approx(0, abs=1e-3)
    assert (moves * (X - 0.5)[:, None]).mean(axis=0) == pytest.approx(0, abs=1e-3)


def test_a_bar_is_silent_at_its_nodes():
    # A xylophone's bars rest at their nodes: 0.2242 of the length from each end.
    for x in (0.2242, 0.7758):
        assert BAR.displacement(x, 0.0)[0] == pytest.approx(0, abs=1e-3)
    assert BAR.displacement(0.5, 0.0)[1::2] == pytest.approx(0, abs=1e-9)
    assert np.abs(BAR.displacement(0.0, 0.0)) == pytest.approx(1, abs=1e-6)


def test_the_frequencies_of_a_bar_are_its_roots_squared():
    beta = np.array([4.730041, 7.853205, 10.995608, 14.137165, 17.278760, 20.420352])
    assert (beta / beta[0]) ** 2 == pytest.approx(BAR.ratios, rel=2e-3)


def test_membrane_modes_are_bessel_functions():
    order = np.array([0, 1, 2, 0, 3, 1, 4, 2])
    zero = np.array([2.4048, 3.8317, 5.1356, 5.5201, 6.3802, 7.0156, 7.5883, 8.4172])
    assert zero / zero[0] == pytest.approx(MEMBRANE.ratios, rel=3e-3)
    most = [np.abs(jv(n, np.linspace(0, 20, 20_001))).max() for n in order]
    for along in (0.0, 0.2, 0.45, 0.5, 0.9):
        radius = 0.9 * abs(2 * along - 1)
        expected = jv(order, zero * radius) / most
        assert MEMBRANE.displacement(along, 0.0) == pytest.approx(expected, abs=1e-4)


@pytest.mark.slow
def test_the_point_of_impact_changes_the_spectrum_of_a_bar(step, score_of, read_wav, tmp_path):
    plank = BodyShape("box", 0.2, 0.012, 0.012)
    pitch = lowest_frequency(plank, solid_of("wood"))

    def lowest_over_next(spot):
        share = []
        for frame in range(1, 12):
            blow = {"cause": "collision", "material": "wood", "surface": "soil"}
            event = step(frame, spot=spot, shape=plank, **blow)
            sound = {"room": "dry", "master": "off"}
            write_wav(score_of([event], 48, sound=sound), tmp_path / "b.wav")
            power = np.abs(np.fft.rfft(read_wav(tmp_path / "b.wav")[:, 0])) ** 2
            f = np.fft.rfftfreq(96_000, 1 / 48_000)
            low, high = (
                power[(f > 0.97 * p) & (f < 1.03 * p)].sum() for p in (pitch, 2.756 * pitch)
            )
            share.append(10 * np.log10(low / high))
        return float(np.mean(share))

    end, node, middle = (lowest_over_next(spot) for spot in (0.0, 0.2242, 0.5))
    # At its node the lowest mode almost vanishes; in the middle the second one does.
    assert node < end - 6
    assert middle > end + 6
