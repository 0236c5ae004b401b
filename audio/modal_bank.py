"""Modal bank: a struck body as a sum of damped sinusoids, a e^{-d t} cos(2π f t + φ) each.

Source: van den Doel and Pai 1998.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from audio.dsp import SILENCE_EXPONENT, SINGLE_THREAD_SIZE, Signal
from audio.time_grid import SAMPLE_RATE

Phasors = NDArray[np.complex128]

# Samples per step of the coarse table of powers; near the square root of a usual length.
_BLOCK = 256
# Blocks with the same modes at first; each later stretch is as long as all before it.
_FIRST_STRETCH = 8
# Powers in a row of the table that the fine one is made of.
_ROW = 16
# What lies below this share of all modes at the impact is left out: -110 dB.
_INAUDIBLE = 3e-6
# A force of one sample.
_TAP = np.ones(1)


@dataclass(frozen=True, slots=True)
class ModalBank:
    """Excited modes of one body.

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
        return float(np.max(SILENCE_EXPONENT / self.decay, initial=0.0))

    @property
    def exponent(self) -> Phasors:
        """Logarithm of the factor of each mode from sample to sample: (M,)."""
        return np.asarray((-self.decay + 2j * np.pi * self.frequency) / SAMPLE_RATE)

    @property
    def start(self) -> Phasors:
        """Each mode at the impact, its first sample as the real part: (M,)."""
        rotor = 1j * np.exp(1j * np.angle(1 - np.exp(self.exponent)))
        return np.asarray(self.amplitude * np.where(rotor.real < 0, -rotor, rotor))

    def with_decay_time(self, seconds: float) -> ModalBank:
        """Return the bank with all decays scaled to reach silence (-60 dB) after a time [s]."""
        if self.decay.size == 0:
            return self
        return ModalBank(self.frequency, self.decay * (self.seconds / seconds), self.amplitude)

    def scaled(self, factor: Signal | float) -> ModalBank:
        """Return the bank with its amplitudes times a factor, (M,) or one for all."""
        return ModalBank(self.frequency, self.decay, self.amplitude * factor)

    @property
    def audible_seconds(self) -> Signal:
        """Times after which each mode is too weak to be heard beside the impact: (M,) [s]."""
        level = np.abs(self.amplitude)
        share = level / max(float(level.sum()) * _INAUDIBLE / max(level.size, 1), 1e-300)
        return np.asarray(np.log(np.maximum(share, 1.0)) / self.decay)


def joined(banks: Sequence[ModalBank]) -> ModalBank:
    """Return the modes of several bodies that ring at once."""
    parts = ((bank.frequency, bank.decay, bank.amplitude) for bank in banks)
    return ModalBank(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def ring(bank: ModalBank, samples: int, force: Signal = _TAP) -> Signal:
    """Return the sum of a bank's modes from the impact on: (samples,).

    The phase makes the sum of all samples of a mode zero: no mode leaves a constant pressure.
    With z = e^{(-d + 2πi f) / r} that sum is Re(e^{iφ} / (1 - z)), so φ is 90° from the angle of
    1 - z; of the two the one that starts upward is taken.

    A force of K samples excites each mode as one impulse of the factor Σ p_k z^{-k} does, once it
    is over. A mode is left out as soon as it is inaudible.

    Args:
        bank: of the body.
        samples: length of the ring.
        force: (K,) of the contact, in shares of its impulse.
    """
    whole = np.zeros(samples)
    if bank.frequency.size == 0 or samples == 0:
        return whole
    exponent = bank.exponent
    start = bank.start
    fine = _powers(exponent)
    head = np.convolve((start @ fine[:, : force.size]).real, force)[: force.size]
    start = start * ((1 / fine[:, : force.size]) @ force)
    # The modes that are heard longest first.
    heard = bank.audible_seconds * SAMPLE_RATE
    order = np.argsort(-heard, kind="stable")
    last = min(-(-samples // _BLOCK), int(heard.max()) // _BLOCK + 1)
    first, step = 0, _FIRST_STRETCH
    while first < last:
        modes = order[: max(np.count_nonzero(heard >= first * _BLOCK), 1)]
        end = min(first + step, last)
        rung = _blocks(exponent[modes], start[modes], fine[modes], np.arange(float(first), end))
        part = whole[first * _BLOCK : end * _BLOCK]
        part[:] = rung[: part.size]
        first, step = end, end
    whole[: head.size] = head[:samples]
    return whole


def _powers(exponent: Phasors) -> Phasors:
    """Return e^{x n} for n from 0 to a block: (M, _BLOCK)."""
    coarse = np.exp(np.outer(exponent, np.arange(_BLOCK // _ROW) * _ROW))
    fine = np.exp(np.outer(exponent, np.arange(_ROW)))
    return np.asarray((coarse[:, :, None] * fine[:, None, :]).reshape(exponent.size, _BLOCK))


def _blocks(exponent: Phasors, start: Phasors, fine: Phasors, blocks: Signal) -> Signal:
    """Return blocks of a sum of modes, one after the other: (N,).

    e^{x n} = e^{x B q} e^{x r}: a product of two small tables instead of M × N exponentials.
    """
    rows = max(SINGLE_THREAD_SIZE // (2 * exponent.size * _BLOCK), 1)
    coarse = np.exp(np.outer(blocks * _BLOCK, exponent)) * start
    left = np.concatenate((coarse.real, -coarse.imag), axis=1)
    right = np.concatenate((fine.real, fine.imag), axis=0)
    parts = [left[i : i + rows] @ right for i in range(0, len(left), rows)]
    return np.concatenate(parts).reshape(-1)
