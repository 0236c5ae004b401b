"""Modal synthesis: the modes of a body that an impact excites.

A mode decays at d = π f tan φ_m + c for the internal friction tan φ_m of a material, its loss
factor, and a damping c of air and support. An impact excites a mode in proportion to the mode's
displacement at the point of impact: a mode is silent if struck at its node. The point along the
body's longest axis is given or random, the point across it is random.

Source: van den Doel and Pai 1998.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from audio.acoustic_materials import Solid
from audio.body_shape import SIDES, STATIONS, BodyShape
from audio.dsp import Signal
from audio.elastic_modes import BodyModes, body_modes, membrane_modes
from audio.modal_bank import ModalBank, Modes, bank_of
from audio.mode_shapes import ModeShape

# Modes outside are inaudible, and would alias above half the sample rate [Hz].
_MIN_FREQUENCY, _MAX_FREQUENCY = 20, 18_000.0
_POISSON_STEP = 0.05
SPEED_OF_SOUND = 343.0
"""In air at 20 °C [m/s]."""


@dataclass(frozen=True, slots=True)
class _Impact:
    """How an impact on a real body differs from a point force on an ideal one.

    Attributes:
        spot_jitter: random offset of the point of impact, as a fraction of the length.
        min_excitation: least excitation of upper modes, because an impact has some width.
        min_excitation_lowest: likewise of the lowest mode.
        detuning: random deviation of upper modes from their ratio.
        level_jitter_db: random deviation of each mode's level [dB].
    """

    spot_jitter: float = 0.02
    min_excitation: float = 0.04
    min_excitation_lowest: float = 0.15
    detuning: float = 0.012
    level_jitter_db: float = 2.0


_IMPACT = _Impact()


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
    frequency = pitch * ratio * (1 + _IMPACT.detuning * rng.uniform(-1, 1, ratio.size) * is_upper)
    level = 10 ** (rng.uniform(-_IMPACT.level_jitter_db, _IMPACT.level_jitter_db, ratio.size) / 20)
    along, across = rng.uniform(0, 1), rng.uniform(0, 1)
    jitter = rng.uniform(-_IMPACT.spot_jitter, _IMPACT.spot_jitter)
    if spot is not None:
        along = min(max(spot + jitter, 0.0), 1.0)
    least = np.where(is_upper, _IMPACT.min_excitation, _IMPACT.min_excitation_lowest)
    excitation = np.maximum(np.abs(shape.displacement(along, across)), least)
    amplitude = level * excitation * (ratio / ratio[0]) ** -tilt
    signed = amplitude * _signs(ratio.size)
    # Modes that cancel at the onset would hide it.
    if signed.sum() > 0.2 * amplitude.sum():
        amplitude = signed
    decay = np.pi * frequency * friction + damping
    audible = (frequency < _MAX_FREQUENCY) & (frequency > _MIN_FREQUENCY)
    return bank_of(frequency[audible], decay[audible], amplitude[audible])


def _signs(modes: int) -> Signal:
    """Return signs of the modes, two of three positive: (M,).

    Equal signs would add up to one spike that masks the ring.
    """
    signs = np.ones(modes)
    signs[2::3] = -1.0
    return signs


def body_bank(
    shape: BodyShape,
    solid: Solid,
    damping: float,
    spot: float | None,
    is_tuned: bool,
    rng: np.random.Generator,
) -> ModalBank:
    """Return the modes of a body that a unit impulse excites, as pressure at the listener.

    A mode's acceleration is ω φ(struck) φ(facing the listener) / mass. The body also recoils as
    a whole: the pressure of a rigid ball of radius a that is pushed is a tone of frequency
    c / (2π a) that decays as fast, the click that is left where all modes are above hearing.

    Source: Morse and Ingard 1968, 7.2, for the ball; both radiate as dipoles.

    Args:
        shape: of the body.
        solid: its material.
        damping: of all modes, from what the body lies on [1/s].
        spot: point of impact along the longest axis, 0 to 1; None for a random one.
        is_tuned: struck for its tone, where its lowest mode moves most.
        rng: of the point of impact, the side that faces the listener, and signs.
    """
    body = _sounding_body(shape, solid, damping)
    struck, facing, *random = rng.random(5).tolist()
    jitter = (2 * random[0] - 1) * _IMPACT.spot_jitter
    sides = [int(SIDES * each) for each in random[1:]]
    if is_tuned:
        # A player strikes where the tone is.
        station, sides[1] = body.loudest
        spot, sides[0] = station / (STATIONS - 1), sides[1]
        facing = spot
    # A body vibrates towards the listener on average; one side of it more or less.
    near = body.about(sides[0], facing)
    if spot is None:
        excitation = body.about(sides[1], struck)
    else:
        excitation = body.at(sides[1], min(max(spot + jitter, 0.0), 1.0))
    amplitude = body.gain.copy()
    amplitude[:-1] *= excitation * near * rng.permutation(body.signs)
    return ModalBank(body.modes, amplitude[body.order])


@dataclass(frozen=True, eq=False)
class _SoundingBody:
    """What a body and its material make of all blows.

    Attributes:
        modes: that are audible, and the recoil of the whole body.
        order: (M,) where they stand among the modes of the shape, N, and the recoil after them.
        gain: (N + 1,) pressure at the listener for displacements of 1, and of the recoil.
        displacement: (SIDES, STATIONS, N) of the modes.
        half_mean_square: (N,) half the mean squares of the displacements.
    """

    modes: Modes
    order: NDArray[np.intp]
    gain: Signal
    displacement: Signal
    half_mean_square: Signal

    @cached_property
    def signs(self) -> Signal:
        """Signs of the modes, to be dealt out: (N,)."""
        return _signs(self.half_mean_square.size)

    @cached_property
    def loudest(self) -> tuple[int, int]:
        """Station and side where the lowest mode moves most."""
        lowest = self.displacement[:, :, 0]
        station, side = np.unravel_index(int(lowest.T.argmax()), lowest.T.shape)
        return int(station), int(side)

    def at(self, side: int, along: float) -> Signal:
        """Return displacements at a place, between stations, from 0 to 1: (N,)."""
        position = along * (STATIONS - 1)
        i = min(int(position), STATIONS - 2)
        table, x = self.displacement[side], position - i
        return np.asarray((1 - x) * table[i] + x * table[i + 1])

    def about(self, side: int, along: float) -> Signal:
        """Return displacements at a place that is only roughly known: (N,).

        Half the mean square is that of the whole surface.
        """
        there = self.at(side, along)
        return np.asarray(np.sqrt(self.half_mean_square + 0.5 * there * there))


@lru_cache(maxsize=256)
def _sounding_body(shape: BodyShape, solid: Solid, damping: float) -> _SoundingBody:
    modes = _modes(shape, solid)
    omega = modes.omega * np.sqrt(solid.young / solid.density) / shape.length
    corner = SPEED_OF_SOUND / shape.radiating_radius
    wave = omega / corner
    gain = np.append(omega * wave / np.sqrt(4 + wave**4), np.sqrt(2) * corner)
    frequency = np.append(omega / (2 * np.pi), corner / (2 * np.pi))
    decay = np.append(0.5 * omega * solid.loss + damping, corner)
    audible = (frequency < _MAX_FREQUENCY) & (frequency > _MIN_FREQUENCY)
    # However small the body, it clicks.
    audible[-1] = True
    frequency[-1] = min(frequency[-1], _MAX_FREQUENCY)
    order = np.flatnonzero(audible)
    order = order[np.argsort(decay[order], kind="stable")]
    return _SoundingBody(
        modes=Modes(frequency[order], decay[order]),
        order=order,
        gain=shape.radiating_radius**2 / (shape.volume * solid.density) * gain,
        displacement=np.ascontiguousarray(modes.displacement.transpose(2, 1, 0)),
        half_mean_square=0.5 * modes.mean_square,
    )


def lowest_frequency(shape: BodyShape, solid: Solid) -> float:
    """Return the frequency of the lowest mode of a body [Hz]."""
    modes = _modes(shape, solid)
    wave_speed = np.sqrt(solid.young / solid.density)
    return float(modes.omega[0] * wave_speed / shape.length / (2 * np.pi))


def _modes(shape: BodyShape, solid: Solid) -> BodyModes:
    if shape.kind == "membrane":
        return membrane_modes()
    # Rounded so that like materials share modes; what cannot be compressed has no finite modes.
    poisson = min(round(solid.poisson / _POISSON_STEP) * _POISSON_STEP, 0.45)
    return body_modes(shape.kind, *shape.proportions, poisson)
