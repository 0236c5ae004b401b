"""Modal synthesis: the ring of a struck body as a bank of damped sinusoids.

Each mode is a e^{-d t} cos(2π f t + φ), with d = π f tan φ_m + c for the internal friction tan φ_m
of a material and a damping c of air and grip. An impact excites a mode in proportion to the mode's
displacement at the point of impact: a mode is silent if struck at its node. Points run from 0 to 1
along the body's longest axis; the point across it is random.

Source: van den Doel and Pai 1998; Fletcher and Rossing 1998 for bar, membrane and bell. The
ratios of plate and shell are chosen by ear, denser and inharmonic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from audio.dsp import SILENCE_EXPONENT, Signal
from audio.time_grid import SAMPLE_RATE

# --- Stick-slip friction of dry surfaces at low speed -----------------------------
# A spring of stiffness k is stretched at a speed v while its end sticks. When its force has grown
# from that of sliding to that of sticking, F_d to F_s, the end slips for half its own oscillation
# period T and sticks again. A cycle lasts 2 (F_s - F_d) / (k v) + T / 2: slow joints tick, fast
# ones squeak, and the squeak is never higher than the oscillation.
#
# Source: Bowden and Leben 1939; the closed form is that of a mass on a belt with two frictions.

SLIP_SHARE = 0.2
"""Share of a cycle that is slip, at the greatest speed."""


def slip_rate(top: Signal, relative_speed: Signal) -> Signal:
    """Return the number of slips a second: (N,).

    Args:
        top: (N,) slips a second at the greatest speed.
        relative_speed: (N,) fraction of that speed, 0 to 1.
    """
    sticking = (1 - SLIP_SHARE) / np.maximum(relative_speed, 1e-4)
    return np.asarray(top / (sticking + SLIP_SHARE))


def slip_impulses(rate: Signal, roughness: float, rng: np.random.Generator) -> Signal:
    """Return impulses at the times of slips, the first at the first sample: (N,).

    Args:
        rate: (N,) slips a second.
        roughness: random deviation of the times, as a share of a cycle.
        rng: of times and strengths.
    """
    phase = np.concatenate(([0.0], np.cumsum(rate)[:-1])) / SAMPLE_RATE
    count = int(phase[-1]) + 1
    cycles = np.arange(count) + roughness * rng.standard_normal(count)
    cycles[0] = 0.0
    position = np.interp(np.sort(cycles), phase, np.arange(phase.size))
    force = 1 + 2 * roughness * rng.standard_normal(count)
    whole = np.minimum(position.astype(np.int64), rate.size - 2)
    impulses = np.zeros(rate.size)
    # An impulse between two samples is shared by both.
    np.add.at(impulses, whole, force * (1 - (position - whole)))
    np.add.at(impulses, whole + 1, force * (position - whole))
    return impulses


def slip_pulse(pitch: float) -> Signal:
    """Return the force of one slip, of zero mean: (K,).

    Args:
        pitch: slips a second at the greatest speed.
    """
    length = max(int(SLIP_SHARE * SAMPLE_RATE / pitch), 4)
    x = 2 * np.pi * (np.arange(length) + 0.5) / length
    # The derivative of a bell: the surface accelerates and comes to rest.
    return np.asarray(np.sin(x))


# Modes outside are inaudible, and would alias above half the sample rate [Hz].
_MIN_FREQUENCY, _MAX_FREQUENCY = 20, 18_000.0
# Samples per step of the coarse table of powers; near the square root of a usual length.
_BLOCK = 256
# Multiplications below which BLAS uses one thread: the bits must not depend on the number of
# threads, and small products are faster without them.
_SINGLE_THREAD_SIZE = 2**17
# Random offset of the point of impact, as a fraction of the length.
_SPOT_JITTER = 0.02
# Least excitation of upper modes and of the lowest: an impact has some width.
_MIN_EXCITATION, _MIN_EXCITATION_LOWEST = 0.04, 0.15
# Random deviation of upper modes from their ratio: real bodies are not ideal ones.
_DETUNING = 0.012
# Random deviation of each mode's level [dB].
_LEVEL_JITTER = 2

Displacement = Callable[[float, float], Signal]
"""Point along (0 to 1) and across (0 to 1) -> (M,) displacement of the modes, at most 1."""


@dataclass(frozen=True, slots=True)
class ModeShape:
    """Modes of an ideal body.

    Attributes:
        ratios: of the modes' frequencies to the lowest.
        displacement: of each mode at a point.
    """

    ratios: tuple[float, ...]
    displacement: Displacement


# Roots of cos β cosh β = 1: a bar free at both ends.
_BAR_ROOTS = np.array([4.730041, 7.853205, 10.995608, 14.137165, 17.278760, 20.420352])
# (diameters, zero of the Bessel function of that order) of a membrane held at its rim.
_MEMBRANE_MODES = (
    *((0, 2.4048), (1, 3.8317), (2, 5.1356), (0, 5.5201)),
    *((3, 6.3802), (1, 7.0156), (4, 7.5883), (2, 8.4172)),
)
# Half waves (along, across) of a plate free at its edges.
_PLATE_MODES = ((1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (2, 2), (3, 1), (0, 3), (1, 3))
# (nodal meridians, nodal circles) of hum, prime, tierce, quint, nominal and higher modes.
_BELL_MODES = (
    *((2, 0), (2, 1), (3, 0), (3, 1), (4, 0), (4, 1)),
    *((5, 1), (5, 0), (6, 0), (7, 0), (8, 0), (9, 0)),
)
# Half waves (around, along).
_SHELL_MODES = ((0, 1), (1, 1), (2, 1), (2, 2), (3, 1), (1, 2), (3, 2), (0, 2), (4, 1), (4, 2))


def _bar(along: float, across: float) -> Signal:
    # About the middle, modes are alternately even and odd; the ends move most.
    x = _BAR_ROOTS * (along - 0.5)
    even = np.cos(x) / np.cos(_BAR_ROOTS / 2) + np.cosh(x) / np.cosh(_BAR_ROOTS / 2)
    odd = np.sin(x) / np.sin(_BAR_ROOTS / 2) + np.sinh(x) / np.sinh(_BAR_ROOTS / 2)
    return np.asarray(np.where(np.arange(_BAR_ROOTS.size) % 2 == 0, even, odd) / 2)


def _plate(along: float, across: float) -> Signal:
    m, n = np.array(_PLATE_MODES).T
    return np.asarray(np.cos(np.pi * m * along) * np.cos(np.pi * n * across))


def _membrane(along: float, across: float) -> Signal:
    order, zero = np.array(_MEMBRANE_MODES).T
    # An impact on the very rim would excite nothing.
    radius = 0.9 * abs(2 * along - 1)
    bessel = _bessel(order, zero * radius)
    return np.asarray(bessel / _BESSEL_MAXIMA * np.cos(np.pi * order * across))


def _bessel(order: Signal, x: Signal) -> Signal:
    """Return J_n(x) by its integral; a mean over a period is exact but for rounding: (M,)."""
    t = 2 * np.pi * np.arange(64) / 64
    return np.asarray(np.cos(np.outer(order, t) - np.outer(x, np.sin(t))).mean(axis=1))


# Maxima of J_0 to J_4.
_BESSEL_MAXIMA = np.array(
    [(1.0, 0.58187, 0.48650, 0.43439, 0.39965)[n] for n, _ in _MEMBRANE_MODES]
)


def _bell(along: float, across: float) -> Signal:
    meridians, circles = np.array(_BELL_MODES).T
    # From the crown, which is held, to the rim, which is free.
    height = np.where(circles == 0, along**1.5, np.sin(1.5 * np.pi * along))
    return np.asarray(height * np.cos(np.pi * meridians * across))


def _shell(along: float, across: float) -> Signal:
    around, lengthwise = np.array(_SHELL_MODES).T
    return np.asarray(np.cos(np.pi * lengthwise * along) * np.cos(np.pi * around * across))


BAR = ModeShape((1.0, 2.756, 5.404, 8.933, 13.34, 18.64), _bar)
PLATE = ModeShape((1.0, 1.73, 2.33, 2.91, 4.10, 4.61, 5.99, 7.42, 8.90, 10.4), _plate)
BELL = ModeShape((0.5, 1.0, 1.2, 1.5, 2.0, 2.5, 2.67, 3.0, 4.0, 5.33, 6.67, 8.0), _bell)
MEMBRANE = ModeShape((1.0, 1.593, 2.136, 2.296, 2.653, 2.918, 3.156, 3.5), _membrane)
SHELL = ModeShape((1.0, 1.42, 2.09, 2.56, 3.39, 4.08, 5.20, 6.63, 8.37, 10.1), _shell)


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

    def with_decay_time(self, seconds: float) -> ModalBank:
        """Return the bank with all decays scaled to reach silence (-60 dB) after a time [s]."""
        if self.decay.size == 0:
            return self
        return ModalBank(self.frequency, self.decay * (self.seconds / seconds), self.amplitude)


def excited_modes(
    shape: ModeShape,
    pitch: float,
    friction: float,
    damping: float,
    tilt: float,
    spot: float | None,
    rng: np.random.Generator,
) -> ModalBank:
    """Return the modes that an impact excites.

    Args:
        shape: of the body.
        pitch: of the lowest mode [Hz].
        friction: tan φ of the material.
        damping: of all modes [1/s].
        tilt: exponent by which higher modes are weaker.
        spot: point of impact along the longest axis, 0 to 1; None for a random one.
        rng: varies point of impact, levels and frequencies.
    """
    ratio = np.asarray(shape.ratios)
    is_upper = ratio > ratio[0]
    # The lowest mode stays in tune.
    frequency = pitch * ratio * (1 + _DETUNING * rng.uniform(-1, 1, ratio.size) * is_upper)
    level = 10 ** (rng.uniform(-_LEVEL_JITTER, _LEVEL_JITTER, ratio.size) / 20)
    along, across = rng.uniform(0, 1), rng.uniform(0, 1)
    jitter = rng.uniform(-_SPOT_JITTER, _SPOT_JITTER)
    if spot is not None:
        along = min(max(spot + jitter, 0.0), 1.0)
    least = np.where(is_upper, _MIN_EXCITATION, _MIN_EXCITATION_LOWEST)
    excitation = np.maximum(np.abs(shape.displacement(along, across)), least)
    amplitude = level * excitation * (ratio / ratio[0]) ** -tilt
    signed = amplitude * _signs(ratio.size, rng)
    # Modes that cancel at the onset would hide it.
    if signed.sum() > 0.2 * amplitude.sum():
        amplitude = signed
    decay = np.pi * frequency * friction + damping
    audible = (frequency < _MAX_FREQUENCY) & (frequency > _MIN_FREQUENCY)
    return ModalBank(frequency[audible], decay[audible], amplitude[audible])


def _signs(modes: int, rng: np.random.Generator) -> Signal:
    """Return random signs of the modes, two of three positive: (M,).

    Equal signs would add up to one spike that masks the ring.
    """
    signs = np.ones(modes)
    signs[2::3] = -1.0
    signs[1:] = rng.permutation(signs[1:])
    return signs


def ring(bank: ModalBank, samples: int) -> Signal:
    """Return the sum of a bank's modes from the impact on: (samples,).

    The phase makes the sum of all samples of a mode zero: no mode leaves a constant pressure.
    With z = e^{(-d + 2πi f) / r} that sum is Re(e^{iφ} / (1 - z)), so φ is 90° from the angle of
    1 - z; of the two the one that starts upward is taken.
    """
    if bank.frequency.size == 0 or samples == 0:
        return np.zeros(samples)
    exponent = (-bank.decay + 2j * np.pi * bank.frequency) / SAMPLE_RATE
    rotor = 1j * np.exp(1j * np.angle(1 - np.exp(exponent)))
    rotor = np.where(rotor.real < 0, -rotor, rotor)
    rows = max(_SINGLE_THREAD_SIZE // (2 * exponent.size * _BLOCK), 1)
    blocks = -(-samples // (_BLOCK * rows)) * rows
    # e^{x n} = e^{x B q} e^{x r}: a product of two small tables instead of M × N exponentials.
    coarse = np.exp(np.outer(np.arange(blocks) * _BLOCK, exponent)) * (bank.amplitude * rotor)
    fine = np.exp(np.outer(exponent, np.arange(_BLOCK)))
    left = np.concatenate((coarse.real, -coarse.imag), axis=1)
    right = np.concatenate((fine.real, fine.imag), axis=0)
    stacked = left.reshape(-1, rows, left.shape[1])
    return np.matmul(stacked, right).reshape(-1)[:samples]


def with_contact_time(response: Signal, taps: int) -> Signal:
    """Return an impulse response as excited by a half-sine force: same shape.

    The longer the contact, the duller the sound.

    Args:
        response: (N,).
        taps: samples that the contact lasts, at least one.
    """
    force = np.sin(np.pi * (np.arange(taps) + 1) / (taps + 1))
    return np.convolve(response, force / force.sum())[: response.size]
