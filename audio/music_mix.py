"""Music mix: the notes of the music as played by the instruments, in a room of their own."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from audio.buses import bus_gain_db, yielding
from audio.config.sound import Sound
from audio.dsp import Gain, Signal, mix_in, pan_gains
from audio.instruments.bent_tone import BendInTime, bent, read_seconds
from audio.instruments.instrument_sound import InstrumentNote, instrument_note, instrument_sound
from audio.layouts import STEREO, Layout
from audio.loudness_at_listener import velocity_of_level
from audio.loudness_meter import integrated_loudness
from audio.notes import MUSIC, Note
from audio.parts import DRUMS
from audio.room_acoustics import Reverberator, RoomAcoustics
from audio.time_grid import sample_at

# A studio's plate: late reverberation alone, for the music is nowhere in the scene.
_STUDIO = RoomAcoustics(size=None, reflectance=0.0, seconds=1.4, wet=10 ** (-6 / 20))


def mix_music(
    mix: Signal,
    sound: Sound,
    notes: Sequence[Note],
    heard: Sequence[Note],
    gain: float,
    layout: Layout,
) -> None:
    """Add the notes of the music to a mix.

    Args:
        mix: (N, C), changed.
        sound: configuration.
        notes: that are added; those of events are left out.
        heard: all notes of the score, to whose voices the music gives way.
        gain: of the music, as a factor.
        layout: of the channels.
    """
    played = [note for note in notes if note.is_music]
    if not played:
        return
    samples = mix.shape[0]
    own = np.zeros_like(mix)
    reverberator = Reverberator(_STUDIO, samples, layout)
    bus = gain * 10 ** (bus_gain_db(sound.mix, MUSIC) / 20)
    # Each sound is synthesised once, and kept only while its notes are mixed.
    alike: dict[tuple[InstrumentNote, BendInTime], list[Note]] = defaultdict(list)
    for note in played:
        program = DRUMS if note.drum else note.program
        velocity = velocity_of_level(note.level)
        bend = tuple((share * note.seconds, semitones) for share, semitones in note.bend)
        seconds = read_seconds(bend, note.rings or note.seconds)
        parameters = instrument_note(program, note.pitch, velocity, seconds)
        alike[parameters, bend].append(note)
    for (parameters, bend), group in alike.items():
        tone = bent(instrument_sound(parameters), bend)
        for note in group:
            start, level = sample_at(note.onset), bus * 10 ** (note.level / 20)
            mix_in(own, start, tone, _gains(note, level, layout))
            reverberator.feed(note.event, start, tone, level, note.send)
    reverberator.add_to(own)
    mix += own * yielding(sound.mix, heard, samples)


def _gains(note: Note, gain: float, layout: Layout) -> tuple[Gain, ...]:
    if layout is STEREO:
        left, right = pan_gains(note.effective_pan)
        return gain * left, gain * right
    return tuple(gain * level for level in layout.gains(float(np.arcsin(note.effective_pan))))


def music_gain(sound: Sound, events: Signal, music: Signal) -> float:
    """Return the gain that makes the music as much louder than the events as it should be.

    Where nothing else is heard it is 1, and the master finds the loudness.

    Args:
        sound: configuration.
        events: mix of the events alone (N, 2).
        music: mix of the music alone (N, 2), with the gain of its bus.
    """
    if sound.music is None:
        return 1.0
    heard, own = integrated_loudness(events), integrated_loudness(music)
    if not (np.isfinite(heard) and np.isfinite(own)):
        return 1.0
    wanted = heard + sound.music.level_db + bus_gain_db(sound.mix, MUSIC)
    return float(10 ** ((wanted - own) / 20))
