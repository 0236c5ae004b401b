"""Sums of modes against the plain sum, under a force and where modes are no longer heard."""

import numpy as np
import pytest

from audio.impact_contact import force_pulse
from audio.modal_bank import ModalBank, audible_seconds, bank_of, ring
from audio.time_grid import SAMPLE_RATE


def plain_ring(bank: ModalBank, samples: int) -> np.ndarray:
    """Return the sum of all modes at each sample, one by one."""
    exponent = (-bank.modes.decay + 2j * np.pi * bank.frequency) / SAMPLE_RATE
    rotor = 1j * np.exp(1j * np.angle(1 - np.exp(exponent)))
    rotor = np.where(rotor.real < 0, -rotor, rotor)
    modes = np.exp(np.outer(np.arange(samples), exponent)) * bank.amplitude * rotor
    return modes.real.sum(axis=1)


def random_bank(seed: int, slowest: float = 5.0) -> ModalBank:
    rng = np.random.default_rng(seed)
    decay = np.append(rng.uniform(slowest, 400.0, 24), rng.uniform(1e3, 1e5))
    amplitude = rng.normal(size=25) * 10 ** rng.uniform(-2.0, 0.0, 25)
    return bank_of(rng.uniform(60.0, 17_000.0, 25), decay, amplitude)


@pytest.mark.parametrize("seconds", [1e-6, 1e-4, 9e-4, 0.02])
def test_a_force_is_convolved_with_the_ring(seconds):
    for seed, samples in enumerate((1, 30, 44, 1000, 20_000)):
        bank, force = random_bank(seed), force_pulse(seconds)
        expected = np.convolve(plain_ring(bank, samples), force)[:samples]
        rung = ring([bank], samples, seconds)
        assert rung.shape == (samples,)
        # What is not heard any more is left out: 90 dB below the peak.
        assert np.abs(rung - expected).max() < 3e-5 * np.abs(plain_ring(bank, samples)).max()


def test_modes_are_left_out_only_when_they_are_inaudible():
    bank = random_bank(7, slowest=40.0)
    rung, expected = ring([bank], SAMPLE_RATE), plain_ring(bank, SAMPLE_RATE)
    assert np.abs(rung - expected).max() < 3e-5 * np.abs(expected).max()
    end = int(audible_seconds([bank]) * SAMPLE_RATE)
    assert np.abs(expected[end:]).max() < 1e-5 * np.abs(bank.amplitude).sum()
    assert not rung[end + 256 :].any()


def test_an_empty_bank_is_silent():
    empty = bank_of(np.zeros(0), np.zeros(0), np.zeros(0))
    assert not ring([empty], 100).any()
    assert ring([random_bank(1)], 0).size == 0
