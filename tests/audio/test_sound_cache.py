"""Synthesised sounds that are kept: the same object again, and no more samples than allowed."""

import pytest

from audio.sound_cache import SoundCache
from audio.synthesis import SoundParameters, synthesize


def knock(size: float) -> SoundParameters:
    plain = (size, 1.0, 2.0, 0.0, 0.0, 0.0, 0)
    return SoundParameters("collision", "wood", "stone", *plain)


def test_a_sound_is_kept_and_nobody_can_change_it():
    cache = SoundCache(synthesize, 2**20)
    sound = cache.sound(knock(0.1), 1)
    assert cache.sound(knock(0.1), 1) is sound
    assert cache.sound(knock(0.1), 2) is not sound
    with pytest.raises(ValueError, match="read-only"):
        sound[0] = 0.0


def test_the_oldest_sounds_make_room():
    asked = []

    def counted(parameters, seed):
        asked.append(parameters.size)
        return synthesize(parameters, seed)

    first = synthesize(knock(0.1), 1)
    cache = SoundCache(counted, most_samples=first.size + 1)
    for size in (0.1, 0.1, 0.2, 0.1):
        cache.sound(knock(size), 1)
    assert asked == [0.1, 0.2, 0.1]
