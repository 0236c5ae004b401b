"""Banks of damped sinusoids: what a body sings when it is struck.

Each mode is a e^{-d t} cos(2π f t + φ), with d = π f tan φ_m + c for the internal friction tan φ_m
of a material and a damping c of air and grip.
Source: van den Doel and Pai 1998.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from audio.grid import SAMPLE_RATE
from audio.shapes import Shape

Signal = NDArray[np.float64]

# Above this, modes alias or only bats hear them [Hz].
_HIGHEST = 18_000.0
# Samples that one complex power steps over: long steps and short ones then cost the same.
_BLOCK = 256
# Multiplications below which BLAS keeps to one thread. Products are cut to this size: threads that
# wait for one another cost more than they bring, and bits must not hang on how many there are.
_SMALL = 2**17
# How far from the same spot a body is struck the next time, and what nodes give all the same.
_BY, _AT_NODES, _LOWEST_AT_NODES = 0.02, 0.04, 0.15
# -60 dB, as an exponent.
_SILENT = float(np.log(1000.0))


@dataclass(frozen=True, slots=True)
class Bank:
    """Modes of one body.

    Attributes:
        frequency: (M,) [Hz].
        decay: (M,) [1/s].
        amplitude: (M,).
    """

    frequency: Signal
    decay: Signal
    amplitude: Signal

    @property
    def seconds(self) -> float:
        """Time in which the last mode falls by 60 dB."""
        return float(np.max(_SILENT / self.decay, initial=0.0))


def struck(
    shape: Shape,
    pitch: float,
    friction: float,
    damping: float,
    tilt: float,
    spot: float | None,
    rng: np.random.Generator,
) -> Bank:
    """Return the modes that a blow on one spot of a body excites.

    Args:
        shape: of the body.
        pitch: of the lowest mode [Hz].
        friction: tan φ of the material.
        damping: of all modes [1/s].
        tilt: exponent by which higher modes are weaker.
        spot: where it is struck along its longest axis, 0 to 1; None to leave it to chance.
        rng: varies the spot across, each mode's share, and by a trifle the spot and frequencies.
    """
    ratio = np.asarray(shape.ratios)
    # No body is the ideal one of its formula; the lowest mode stays in tune.
    detuned = pitch * ratio * (1 + 0.012 * rng.uniform(-1, 1, ratio.size) * (ratio > ratio[0]))
    share = 10 ** (rng.uniform(-2, 2, ratio.size) / 20)
    along, across, by = rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(-_BY, _BY)
    if spot is not None:
        along = min(max(spot + by, 0.0), 1.0)
    moves = shape.moves(along, across)
    # A blow has some width: a node is never quite silent, and the lowest mode never gone.
    least = np.where(ratio > ratio[0], _AT_NODES, _LOWEST_AT_NODES)
    heard = (detuned < _HIGHEST) & (detuned > 20)
    amplitude = share * np.maximum(np.abs(moves), least) * (ratio / ratio[0]) ** -tilt
    signed = amplitude * _signs(ratio.size, rng)
    # Modes that cancel at the onset would hide it.
    if signed.sum() > 0.2 * amplitude.sum():
        amplitude = signed
    decay = np.pi * detuned * friction + damping
    return Bank(detuned[heard], decay[heard], amplitude[heard])


def _signs(modes: int, rng: np.random.Generator) -> Signal:
    """Return which modes start downward where one listens, some with and some against others.

    All upward would pile up to one spike that hides the ring: (modes,).
    """
    signs = np.ones(modes)
    signs[2::3] = -1.0
    signs[1:] = rng.permutation(signs[1:])
    return signs


def lasting(bank: Bank, seconds: float) -> Bank:
    """Return the bank with all decays scaled so that it is silent (-60 dB) after a time [s]."""
    if bank.decay.size == 0:
        return bank
    return Bank(bank.frequency, bank.decay * (bank.seconds / seconds), bank.amplitude)


def ring(bank: Bank, samples: int) -> Signal:
    """Return the sum of a bank's modes from the blow on: (samples,).

    The phase is the one for which the sum of all samples of a mode is zero: no mode leaves a
    constant pressure behind. With z = e^{(-d + 2πi f) / r} that sum is Re(e^{iφ} / (1 - z)), so φ
    is 90° from the angle of 1 - z; of the two the one that starts upward is taken.
    """
    if bank.frequency.size == 0 or samples == 0:
        return np.zeros(samples)
    exponent = (-bank.decay + 2j * np.pi * bank.frequency) / SAMPLE_RATE
    rotor = 1j * np.exp(1j * np.angle(1 - np.exp(exponent)))
    rotor = np.where(rotor.real < 0, -rotor, rotor)
    rows = max(_SMALL // (2 * exponent.size * _BLOCK), 1)
    blocks = -(-samples // (_BLOCK * rows)) * rows
    # e^{x n} = e^{x B q} e^{x r}: a product of two small tables instead of M × N exponentials.
    coarse = np.exp(np.outer(np.arange(blocks) * _BLOCK, exponent)) * (bank.amplitude * rotor)
    fine = np.exp(np.outer(exponent, np.arange(_BLOCK)))
    left = np.concatenate((coarse.real, -coarse.imag), axis=1)
    right = np.concatenate((fine.real, fine.imag), axis=0)
    stacked = left.reshape(-1, rows, left.shape[1])
    whole: Signal = np.matmul(stacked, right).reshape(-1)[:samples]
    return whole


def hit(sound: Signal, taps: int) -> Signal:
    """Return a ring as excited by a contact of some length instead of an instant: same shape.

    The force rises and falls as half a sine; the longer the contact, the duller the sound.

    Args:
        sound: (N,) response to an instant.
        taps: samples that the contact lasts, at least one.
    """
    force = np.sin(np.pi * (np.arange(taps) + 1) / (taps + 1))
    return np.convolve(sound, force / force.sum())[: sound.size]
