"""Sound facts: a film's sound as it was written, and how the film's track carries it.

What was written is compared closely: it is the same on every class of processor. The film's track
went through an encoder whose noise is not, 31 to 34 dB below the sound; so it is compared with what
was written.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens.sound_levels import (
    CHANNELS,
    TOLERANCE,
    Levels,
    level_changes,
    level_differences,
    level_rows,
    levels_from,
    levels_of,
    loudness_text,
    window_of,
)
from pipeline.production.goldens.sound_onsets import EXACT, RATE, SILENCE, Onset, common_shift

Side = NDArray[np.floating[Any]]
"""Samples (N,) of a channel."""

Sides = NDArray[np.floating[Any]]
"""Samples (channels, N)."""

_MAX_LISTED: Final = 6
"""Onsets that are listed one by one."""

_NO_GAIN: Final = 1e-4
"""Of a channel that is silent, or inverted."""

_LOUD_RANGE: Final = 30.0
"""Range below the loudest window in which changes by the encoder count [dB]."""

_WHOLE: Final = ("throughout", "silent")
"""Ends of what is told of a whole channel."""

_LATE_REACH: Final = RATE // 4
"""Largest delay of a film's track that is measured [samples]."""

_LATE_LENGTH: Final = 2**17
"""Length of the sound from which the delay is measured [samples]."""

_NOISE_RISE: Final = 3.0
"""Rise of the encoder's noise that is let pass [dB]; on another class of processor it is 1."""

_WORST_RISE: Final = 0.5
"""Of the largest change of a level by the encoder that is let pass [dB]; there it is 0.1."""

_LATE_TOLERANCE: Final = 2
"""Of the delay of the film's track [samples]: the peak of a deep sound is flat."""


@dataclass(frozen=True, slots=True)
class Carriage:
    """How the film's track carries one channel of the sound.

    Attributes:
        late: delay [samples].
        gain: [dB].
        noise: of the encoder, relative to the sound [dB].
        worst: largest change of the level of a window [dB].
    """

    late: int
    gain: float
    noise: float
    worst: float


@dataclass(frozen=True, slots=True)
class SoundFacts:
    """Facts of the sound of a film.

    Attributes:
        samples: number of samples that were written.
        digest: of these.
        window: of the levels [samples].
        levels: of what was written.
        carried: by the film's track, a channel each; None for silence.
    """

    samples: int
    digest: str
    window: int
    levels: Levels
    carried: tuple[Carriage | None, ...]

    def members(self) -> dict[str, Any]:
        """Return the facts as plain values; windows of silence are left out."""
        return {
            "samples": self.samples,
            "digest": self.digest,
            "window": self.window,
            "carried": [one and [one.late, one.gain, one.noise, one.worst] for one in self.carried],
            "levels": dict(level_rows(self.levels)),
        }


def facts_of_sound(written: Sides, heard: Sides) -> SoundFacts:
    """Return the facts of a sound.

    Args:
        written: (2, N).
        heard: (channels, M) of the film.
    """
    samples = written.shape[1]
    window = window_of(samples)
    found = np.zeros_like(written)
    length = min(heard.shape[1], samples)
    found[: len(heard), :length] = heard[: len(found), :length]
    digest = hashlib.blake2b(digest_size=10)
    for first in range(0, samples, window):
        digest.update(np.rint(written[:, first : first + window] * 2.0**23).astype("<i4").tobytes())
    return SoundFacts(
        samples,
        digest.hexdigest(),
        window,
        levels_of(written, window),
        tuple(_carriage(*pair, window) for pair in zip(written, found, strict=True)),
    )


def _carriage(written: Side, heard: Side, window: int) -> Carriage | None:
    """Return how a channel (N,) is heard, None if nothing was written in it."""
    silence = written.size * 10 ** (SILENCE / 10)
    if _products(written, written, window).sum() <= silence:
        return None
    audible = _products(heard, heard, window).sum() > silence
    late = _delay(written, heard) if audible else 0
    heard = np.roll(heard, -late) if late else heard
    own, both, other = (
        _products(*pair, window) for pair in ((written, written), (written, heard), (heard, heard))
    )
    gain = float(both.sum() / own.sum())
    # What remains of the track without the sound in it.
    noise = float(other.sum() - gain * both.sum()) / max(gain**2 * float(own.sum()), 1e-12)
    before, after = (10.0 * np.log10(np.maximum(p / window, 1e-12)) for p in (own, other))
    changes = level_changes(before, after)[before > before.max() - _LOUD_RANGE]
    return Carriage(
        late,
        round(20.0 * float(np.log10(max(gain, _NO_GAIN))), 1) + 0.0,
        round(10.0 * float(np.log10(max(noise, 1e-9))), 1),
        round(float(np.abs(changes).max()), 1),
    )


def _products(one: Side, other: Side, window: int) -> NDArray[np.float64]:
    """Return the inner products of two channels (N,) in windows."""
    firsts = range(0, one.size, window)
    pairs = ((one[k : k + window], other[k : k + window]) for k in firsts)
    return np.array([np.dot(a.astype(np.float64), b.astype(np.float64)) for a, b in pairs])


def _delay(written: Side, heard: Side) -> int:
    """Return the delay of a channel [samples], measured where it is loudest."""
    middle = int(np.argmax(np.abs(written)))
    first = max(min(middle - _LATE_LENGTH // 2, written.size - _LATE_LENGTH), 0)
    old, new = (sound[first : first + _LATE_LENGTH] for sound in (written, heard))
    size = 2 * _LATE_LENGTH
    spectrum = np.fft.rfft(new, size) * np.conj(np.fft.rfft(old, size))
    likeness = np.fft.irfft(spectrum, size)
    lags = np.arange(-_LATE_REACH, _LATE_REACH + 1)
    return int(lags[np.argmax(np.abs(likeness[lags]))])


def sound_from(members: dict[str, Any]) -> SoundFacts:
    """Return the facts that `SoundFacts.members` told.

    Raises:
        ValueError, KeyError, TypeError: the values are damaged.
    """
    samples, window = int(members["samples"]), int(members["window"])
    rows = {int(k): [float(level) for level in row] for k, row in members["levels"].items()}
    if len(members["carried"]) != len(CHANNELS):
        raise ValueError(f"it has {len(members['carried'])} channels where 2 belong")
    return SoundFacts(
        samples,
        str(members["digest"]),
        window,
        levels_from(rows, -(-samples // window)),
        tuple(
            None if one is None else Carriage(int(one[0]), *(float(x) for x in one[1:]))
            for one in members["carried"]
        ),
    )


def sound_differences(
    golden: SoundFacts, new: SoundFacts, onsets: Sequence[str], late: bool
) -> Iterator[str]:
    """Yield the differences of a sound from its golden as text.

    Args:
        golden: expected facts.
        new: present facts.
        onsets: differences of the onsets, as text.
        late: whether the whole sound is, so that all its onsets and levels differ.
    """
    written: list[str] = []
    if golden.digest != new.digest and not late and golden.window == new.window:
        written = level_differences(golden.levels, new.levels, golden.window / RATE)
    yield from written
    if not late:
        whole = [text for text in written if text.endswith(_WHOLE)]
        yield from (text for text in onsets if not _told_already(text, whole))
    same = not late and not written
    for name, then, now in zip(CHANNELS, golden.carried, new.carried, strict=True):
        if then is not None and now is not None:
            yield from _carriage_differences(name, then, now, same)


def _told_already(onset: str, whole: Sequence[str]) -> bool:
    """Return whether the difference of an onset belongs to one of its channel or of the sound."""
    return any(
        text.startswith("the sound")
        or any(f"the {name} channel" in text and onset.endswith(name) for name in CHANNELS)
        for text in whole
    )


def _carriage_differences(name: str, then: Carriage, now: Carriage, same: bool) -> Iterator[str]:
    """Yield the difference of a channel in the film's track as text.

    Args:
        name: of the channel.
        then: of the golden.
        now: of the film.
        same: whether the same sound was written; the noise depends on it.
    """
    track = f"the film's track: the {name} channel"
    if abs(now.late - then.late) > _LATE_TOLERANCE:
        yield f"{track} is {shift_text(now.late - then.late)} against the sound that was written"
    elif now.gain <= 20.0 * np.log10(_NO_GAIN) < then.gain:
        yield f"{track} is silent or inverted"
    elif abs(now.gain - then.gain) > TOLERANCE:
        yield f"{track} is {loudness_text(now.gain - then.gain)} than written"
    elif same and now.noise > then.noise + _NOISE_RISE:
        yield (
            f"{track} has noise {-now.noise:.0f} dB below the sound, "
            f"in the golden {-then.noise:.0f}"
        )
    elif same and now.worst > then.worst + _WORST_RISE:
        yield f"{track} is up to {now.worst:.1f} dB off, the golden's {then.worst:.1f}"


def shift_text(samples: float) -> str:
    """Return a delay as text."""
    fate = "late" if samples > 0 else "early"
    count = abs(samples)
    told = f"{count:.0f} samples" if count >= 2 else f"{count:.1f} samples"
    return f"{told} ({1000 * count / RATE:.3g} ms) {fate}"


def onset_differences(then: Sequence[Onset], now: Sequence[Onset], frame: float) -> list[str]:
    """Return the onsets that start at another sample or with another level, as text.

    Args:
        then: measured onsets of the golden.
        now: of the film.
        frame: duration of a frame [s]; onsets of half a frame apart are not the same.
    """
    found: list[str] = []
    moments = np.array([onset.moment for onset in now])
    for old in then:
        if not moments.size:
            break
        new = now[int(np.argmin(np.abs(moments - old.moment)))]
        if abs(new.moment - old.moment) < frame / 2:
            found.extend(_onset_texts(old, new))
    more = [f"and {len(found) - _MAX_LISTED} more"] if len(found) > _MAX_LISTED else []
    return found[:_MAX_LISTED] + more


def _onset_texts(old: Onset, new: Onset) -> Iterator[str]:
    where = f"the sound at {old.moment:.3f} s"
    late = {
        name: b - a
        for name, a, b in zip(CHANNELS, old.instants, new.instants, strict=False)
        if a is not None and b is not None and abs(b - a) > EXACT
    }
    changes = level_changes(np.array([old.levels]), np.array([new.levels]))[0]
    loud = {
        name: float(change)
        for name, change in zip(CHANNELS, changes, strict=False)
        if abs(change) > TOLERANCE
    }
    for amounts, text in ((late, shift_text), (loud, loudness_text)):
        if not amounts:
            continue
        name = max(amounts, key=lambda key: abs(amounts[key]))
        side = "" if len(amounts) == len(CHANNELS) else f" on the {name}"
        yield f"{where} is {text(amounts[name])}{side}"


def late_text(then: Sequence[Onset], now: Sequence[Onset], frame: float) -> str:
    """Return the delay of the whole sound as text, empty if there is none.

    Args:
        then: onsets of the golden.
        now: of the film.
        frame: duration of a frame [s].
    """
    late = common_shift(then, now)
    if not late:
        return ""
    frames = abs(late) / frame
    count = "a frame" if round(frames, 1) == 1.0 else f"{frames:.3g} frames"
    return f"the sound is {shift_text(late * RATE)}: {count}"
