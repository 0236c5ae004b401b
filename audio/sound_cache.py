"""Sound cache: synthesised sounds of this process, so that a track and its stems share them."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock

from audio.dsp import Signal
from audio.synthesis import SoundParameters, synthesize

# Samples that are kept: 64 MiB of them.
_MOST_SAMPLES = 2**23


class SoundCache:
    """The sounds that were asked for last, up to a number of samples.

    Args:
        most_samples: of all sounds together.
    """

    def __init__(self, most_samples: int = _MOST_SAMPLES) -> None:
        self._most_samples = most_samples
        self._samples = 0
        self._sounds: OrderedDict[tuple[SoundParameters, int], Signal] = OrderedDict()
        self._lock = Lock()

    def sound(self, parameters: SoundParameters, seed: int) -> Signal:
        """Return a sound, (N,), which nobody may change."""
        key = parameters, seed
        with self._lock:
            sound = self._sounds.get(key)
            if sound is not None:
                self._sounds.move_to_end(key)
                return sound
        sound = synthesize(parameters, seed)
        sound.setflags(write=False)
        with self._lock:
            if key not in self._sounds:
                self._sounds[key] = sound
                self._samples += sound.size
            while self._samples > self._most_samples and len(self._sounds) > 1:
                self._samples -= self._sounds.popitem(last=False)[1].size
        return sound


SOUNDS = SoundCache()
"""The sounds of this process."""
