"""Modal bank: a struck body as a sum of damped sinusoids, a e^{-d t} cos(2π f t + φ) each.

What depends on the body alone is kept with its modes, so that its next ring costs little.

Source: van den Doel and Pai 1998.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from audio.dsp import SILENCE_EXPONENT, SINGLE_THREAD_SIZE, Signal
from audio.impact_contact import contact_attenuation, force_matrix, force_pulse
from audio.time_grid import SAMPLE_RATE

Phasors = NDArray[np.complex128]

# Samples per step of the coarse table of powers; near the square root of a usual length.
_BLOCK = 256
# Blocks with the same modes at first; each later stretch is as long as all before it.
_FIRST_STRETCH = 8
# Powers in a row of the table that the fine one is made of.
_ROW = 16
# What lies below this share of all modes at the impact is left out: -102 dB.
_INAUDIBLE = 8e-6


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of one body, those that ring longest first.

    Attributes:
        frequency: (M,) [Hz].
        decay: (M,) [1/s], ascending.
    """

    frequency: Signal
    decay: Signal

    @cached_property
    def lowest(self) -> float:
        """Lowest frequency [Hz]."""
        return float(self.frequency.min(initial=np.inf))

    @cached_property
    def exponent(self) -> Phasors:
        """Logarithm of the factor of each mode from sample to sample: (M,)."""
        return np.asarray((-self.decay + 2j * np.pi * self.frequency) / SAMPLE_RATE)

    @cached_property
    def rotor(self) -> Phasors:
        """Phase of each mode at the impact, of magnitude 1 and with a positive real part: (M,).

        It makes the sum of all samples of a mode zero: no mode leaves a constant pressure. With
        z = e^{(-d + 2πi f) / r} that sum is Re(e^{iφ} / (1 - z)), so φ is 90° from the angle of
        1 - z; of the two the one that starts upward is taken.
        """
        rotor = 1j * np.exp(1j * np.angle(1 - np.exp(self.exponent)))
        return np.asarray(np.where(rotor.real < 0, -rotor, rotor))

    @cached_property
    def powers(self) -> Phasors:
        """e^{x n} for n from 0 to a block, of the exponents x: (M, _BLOCK)."""
        coarse = np.exp(np.outer(self.exponent, np.arange(_BLOCK // _ROW) * _ROW))
        fine = np.exp(np.outer(self.exponent, np.arange(_ROW)))
        return np.asarray((coarse[:, :, None] * fine[:, None, :]).reshape(-1, _BLOCK))

    @cached_property
    def rows(self) -> Signal:
        """Real part and negative imaginary part of the powers of each mode: (2 M, _BLOCK)."""
        parts = np.stack((self.powers.real, -self.powers.imag), axis=1)
        return np.ascontiguousarray(parts.reshape(-1, _BLOCK))

    def excited(self, contact: float) -> tuple[Signal, Phasors, Phasors]:
        """Return what a contact of a duration [s] makes of modes of amplitude 1.

        Returns:
            (M,) what is left of them of what is longer than the longest force; (M, K) their
            samples under the force, as the real part; (M,) the impulse after it.
        """
        if contact not in self._excited:
            force = force_pulse(contact)
            powers = self.powers[:, : force.size]
            left = contact_attenuation(self.frequency, contact)
            impulse = np.asarray((1 / powers) @ force)
            self._excited[contact] = left, powers @ force_matrix(contact), impulse
        return self._excited[contact]

    def damped(self, factor: float) -> Modes:
        """Return the modes with all decays times a factor; the last ones asked for are kept."""
        kept = self._damped[0]
        if kept is None or kept[0] != factor:
            kept = factor, Modes(self.frequency, self.decay * factor)
            self._damped[0] = kept
        return kept[1]

    @cached_property
    def _damped(self) -> list[tuple[float, Modes] | None]:
        return [None]

    @cached_property
    def _excited(self) -> dict[float, tuple[Signal, Phasors, Phasors]]:
        return {}


@dataclass(frozen=True, slots=True)
class ModalBank:
    """Excited modes of one body.

    Attributes:
        modes: of the body.
        amplitude: (M,).
    """

    modes: Modes
    amplitude: Signal

    @property
    def frequency(self) -> Signal:
        """Frequencies of the modes: (M,) [Hz]."""
        return self.modes.frequency

    @property
    def seconds(self) -> float:
        """Time in which the last mode falls by 60 dB."""
        decay = self.modes.decay
        return SILENCE_EXPONENT / float(decay[0]) if decay.size else 0.0

    @property
    def start(self) -> Phasors:
        """Each mode at the impact, its first sample as the real part: (M,)."""
        return np.asarray(self.amplitude * self.modes.rotor)

    def with_decay_time(self, seconds: float) -> ModalBank:
        """Return the bank with all decays scaled to reach silence (-60 dB) after a time [s]."""
        return ModalBank(self.modes.damped(self.seconds / seconds), self.amplitude)

    def struck(self, contact: float) -> ModalBank:
        """Return the bank weakened by all of a contact of a duration [s] but its force pulse."""
        return self.scaled(self.modes.excited(contact)[0])

    def scaled(self, factor: Signal | float) -> ModalBank:
        """Return the bank with its amplitudes times a factor, (M,) or one for all."""
        return ModalBank(self.modes, self.amplitude * factor)

    def audible_seconds(self, floor: float) -> Signal:
        """Return the times after which each mode is weaker than a level: (M,) [s]."""
        share = np.abs(self.amplitude) / max(floor, 1e-300)
        return np.asarray(np.log(np.maximum(share, 1.0)) / self.modes.decay)


def bank_of(frequency: Signal, decay: Signal, amplitude: Signal) -> ModalBank:
    """Return a bank of modes in any order.

    Args:
        frequency: (M,) [Hz].
        decay: (M,) [1/s].
        amplitude: (M,).
    """
    order = np.argsort(decay, kind="stable")
    return ModalBank(Modes(frequency[order], decay[order]), amplitude[order])


def audible_seconds(banks: Sequence[ModalBank]) -> float:
    """Return the time after which no mode of bodies that ring at once is heard [s]."""
    floor = _inaudible(banks)
    return max(float(bank.audible_seconds(floor).max(initial=0.0)) for bank in banks)


def _inaudible(banks: Sequence[ModalBank]) -> float:
    """Return the level below which a mode is not heard beside all others."""
    whole = sum(float(np.abs(bank.amplitude).sum()) for bank in banks)
    return whole * _INAUDIBLE / max(sum(bank.amplitude.size for bank in banks), 1)


def ring(banks: Sequence[ModalBank], samples: int, contact: float = 0.0) -> Signal:
    """Return the sum of the modes of bodies that ring at once, from the impact on: (samples,).

    A force p of K samples excites each mode as one impulse of the factor Σ p_k z^{-k} does, once
    it is over. A mode is left out as soon as it is inaudible.

    Args:
        banks: of the bodies.
        samples: length of the ring.
        contact: its duration [s]; that of an impulse is 0.
    """
    # Whole blocks.
    whole = np.zeros(-(-samples // _BLOCK) * _BLOCK)
    head = np.zeros(min(force_pulse(contact).size, samples))
    floor = _inaudible(banks)
    for bank in banks:
        if bank.amplitude.size and samples:
            start = bank.start
            _, under, impulse = bank.modes.excited(contact)
            head += (start @ under[:, : head.size]).real
            _add_blocks(whole, bank, start * impulse, floor)
    whole[: head.size] = head
    return whole[:samples]


def _add_blocks(whole: Signal, bank: ModalBank, start: Phasors, floor: float) -> None:
    """Add the modes of a bank, as far as they are heard.

    e^{x n} = e^{x B q} e^{x r}: a product of two small tables instead of M × N exponentials.

    Args:
        whole: whole blocks, changed.
        bank: of the body.
        start: (M,) of its modes.
        floor: level below which they are not heard.
    """
    heard = bank.audible_seconds(floor) * (SAMPLE_RATE / _BLOCK)
    last = min(whole.size // _BLOCK, int(heard.max()) + 1)
    first, step = 0, _FIRST_STRETCH
    while first < last:
        # The last of the modes that are heard, all before it ring longer.
        modes = int(np.flatnonzero(heard >= first)[-1]) + 1
        end = min(first + step, last)
        # Products of few rows at once, whose sums no number of threads changes.
        few = max(SINGLE_THREAD_SIZE // (2 * modes * _BLOCK), 1)
        blocks = np.arange(float(first), end)[:, None] * _BLOCK
        left = (np.exp(blocks * bank.modes.exponent[:modes]) * start[:modes]).view(np.float64)
        for i in range(0, end - first, few):
            part = left[i : i + few]
            there = whole[(first + i) * _BLOCK : (first + i + len(part)) * _BLOCK]
            there += (part @ bank.modes.rows[: 2 * modes]).reshape(-1)
        first, step = end, end
