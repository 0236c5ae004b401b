"""Sound cache: sounds of this process, so that what sounds alike is synthesised once."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

from audio.dsp import Signal

P = TypeVar("P", bound=Hashable)


class SoundCache(Generic[P]):
    """The sounds that were asked for last, up to a number of samples.

    Args:
        synthesize: returns the sound of some parameters and a seed, (N,).
        most_samples: of all sounds together.
    """

    def __init__(self, synthesize: Callable[[P, int], Signal], most_samples: int) -> None:
        self._synthesize = synthesize
        self._most_samples = most_samples
        self._samples = 0
        self._sounds: OrderedDict[tuple[P, int], Signal] = OrderedDict()
        self._lock = Lock()

    def sound(self, parameters: P, seed: int) -> Signal:
        """Return a sound, (N,), which nobody may change."""
        key = parameters, seed
        with self._lock:
            sound = self._sounds.get(key)
            if sound is not None:
                self._sounds.move_to_end(key)
                return sound
        sound = self._synthesize(parameters, seed)
        sound.setflags(write=False)
        with self._lock:
            if key not in self._sounds:
                self._sounds[key] = sound
                self._samples += sound.size
            while self._samples > self._most_samples and len(self._sounds) > 1:
                self._samples -= self._sounds.popitem(last=False)[1].size
        return sound
