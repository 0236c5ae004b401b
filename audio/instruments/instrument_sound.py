"""Instrument sound: the voice of each program of General MIDI, and a note of it as samples."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from audio.dsp import SILENCE_EXPONENT, Signal, band_noise, normalized, without_rumble
from audio.general_midi import FAMILY_SIZE, INSTRUMENTS, LOWEST_DRUM_KEY
from audio.harmony import frequency_of
from audio.instruments.drum_kit import KIT
from audio.instruments.plucked_string import StringVoice, plucked_string
from audio.instruments.struck_tone import StruckVoice, piano_voice, struck_tone
from audio.instruments.sustained_tone import ToneVoice, sustained_tone
from audio.parts import DRUMS
from audio.seeded import seeded
from audio.time_grid import SAMPLE_RATE

_FADE = int(0.006 * SAMPLE_RATE)
_MIN_ONSET = 2e-3
# Strings that are damped when they are let go fall by 60 dB in this time [s].
_STRING_RELEASE = 0.12
_LONGEST_STRING = 6.0
# Like programs of one pitch share a sound where their strength is alike.
_STRENGTHS = 8
_LENGTH_STEP = 0.02
LONGEST_NOTE = 60.0
"""For which a note is held at most [s]."""

# RMS of the loudest 50 ms to which notes of peak 1 are brought, so that a flute is as loud as a
# harpsichord of one velocity.
_LOUDNESS, _LOUDNESS_WINDOW = 0.22, 2400
_MOST_PEAK = 1.0
_DRUM_DRIVE = 2.2

Voice = StringVoice | ToneVoice | StruckVoice

_BOW = ((300.0, 150.0, 0.6), (700.0, 300.0, 0.8), (2500.0, 1500.0, 1.0))
_AAH = ((700.0, 160.0, 1.0), (1150.0, 180.0, 0.7), (2700.0, 350.0, 0.25), (200.0, 250.0, 0.5))
_OOH = ((350.0, 150.0, 1.0), (800.0, 180.0, 0.45), (2500.0, 350.0, 0.08), (200.0, 250.0, 0.5))
_BELL = StruckVoice(
    (0.5, 1.0, 1.183, 1.506, 2.0, 2.514, 2.662, 3.011, 4.166),
    (0.45, 1.0, 0.5, 0.3, 0.8, 0.3, 0.25, 0.25, 0.2),
    3.5,
)
_MARIMBA = StruckVoice((1.0, 3.93, 9.6), (1.0, 0.25, 0.08), 0.9, 0.6, 1.2, 1.2, 0.08)
_HARP = StringVoice(2.2, 0.5, 0.35, 0.05)
_NYLON = StringVoice(2.0, 0.35, 0.25, 0.06)
_BASS = StringVoice(1.8, 0.18, 0.22, 0.10)
_REED_TUBE = ((800.0, 500.0, 1.0), (1900.0, 900.0, 0.6), (250.0, 300.0, 0.8))
_SAX = ToneVoice("reed", 0.03, 0.1, 1300, 5200, 12, noise=0.03, formants=_REED_TUBE)
_VIOLIN = ToneVoice("sawtooth", 0.06, 0.18, 2200, 6500, 14, noise=0.01, formants=_BOW)
_ENSEMBLE = ToneVoice("sawtooth", 0.12, 0.4, 1300, 4500, 9, 3, 6.0)
_PAD = ToneVoice("sawtooth", 0.35, 0.9, 600, 2200, 0, 3, 7.0)
_BRASS = ToneVoice("brass", 0.04, 0.12, 900, 5200, 6)
_FLUTE = ToneVoice("flute", 0.05, 0.12, 1800, 5000, 14, noise=0.04)

# The usual voice of each family, in the order of the programs.
_FAMILIES: tuple[Voice, ...] = (
    *(piano_voice(6.0, 1.1, 0.05), _MARIMBA, ToneVoice("organ", 0.012, 0.06, 4000, 9000)),
    *(_NYLON, _BASS, _VIOLIN, _ENSEMBLE, _BRASS, _SAX, _FLUTE),
    *(ToneVoice("sawtooth", 0.01, 0.1, 2500, 7000), _PAD, replace(_PAD, attack=0.2), _NYLON),
    *(_BELL, _PAD),
)

_VOICES: dict[str, Voice] = {
    "bright acoustic piano": piano_voice(5.5, 0.85, 0.06),
    "honky-tonk piano": piano_voice(4.5, 0.8, 0.06),
    "electric piano 1": StruckVoice(
        (1, 2, 7.1, 14.3), (1, 0.18, 0.12, 0.04), 3.5, 0.4, 0.9, strike=0.01, release=0.15
    ),
    "electric piano 2": StruckVoice(
        (1, 2, 3, 11.2), (1, 0.4, 0.15, 0.06), 3.0, 0.4, 0.7, strike=0.01, release=0.15
    ),
    "harpsichord": StringVoice(2.2, 1.2, 0.12, 0.005),
    "clavinet": StringVoice(1.4, 0.7, 0.1, 0.01),
    "celesta": StruckVoice((1, 4.0, 10.8), (1, 0.22, 0.06), 1.8, 0.5),
    "glockenspiel": StruckVoice((1, 2.76, 5.4, 8.9), (1, 0.4, 0.2, 0.1), 2.6, 0.4),
    "music box": StruckVoice((1, 6.27, 17.5), (1, 0.15, 0.04), 2.0, 0.4),
    "vibraphone": StruckVoice((1, 3.98, 10.6), (1, 0.18, 0.05), 4.0, 0.5, strike=0.02),
    "xylophone": StruckVoice((1, 3.0, 6.1), (1, 0.45, 0.2), 0.5, 0.6, 0.9, strike=0.08),
    "tubular bells": _BELL,
    "dulcimer": StringVoice(2.6, 0.9, 0.15, 0.01),
    "reed organ": ToneVoice("double reed", 0.05, 0.1, 2500, 6000),
    "accordion": ToneVoice("double reed", 0.04, 0.08, 3000, 7000, 0, 2, 4.0),
    "harmonica": ToneVoice("double reed", 0.03, 0.08, 2500, 6000, 10),
    "tango accordion": ToneVoice("double reed", 0.03, 0.08, 2200, 6000),
    "church organ": ToneVoice("organ", 0.06, 0.35, 5000, 9000, 0, 2, 1.5),
    "steel guitar": StringVoice(2.6, 0.8, 0.18, 0.02),
    "jazz guitar": StringVoice(2.0, 0.2, 0.3, 0.08),
    "clean guitar": StringVoice(2.6, 0.6, 0.2, 0.03),
    "muted guitar": StringVoice(0.25, 0.1, 0.1, 0.04),
    "overdriven guitar": StringVoice(4.0, 1.5, 0.15, 0.02, drive=3.0),
    "distortion guitar": StringVoice(6.0, 2.0, 0.12, 0.02, drive=9.0),
    "picked bass": StringVoice(1.8, 0.35, 0.12, 0.03),
    "slap bass 1": StringVoice(1.6, 0.5, 0.1, 0.015),
    "slap bass 2": StringVoice(1.4, 0.6, 0.08, 0.01),
    "fretless bass": StringVoice(2.4, 0.12, 0.3, 0.14),
    "synth bass 1": ToneVoice("sawtooth", 0.005, 0.08, 350, 1800, decay=1.6),
    "synth bass 2": ToneVoice("square", 0.005, 0.08, 300, 1200, decay=1.2),
    "contrabass": replace(_VIOLIN, dark=900, bright=2600, attack=0.09),
    "cello": replace(_VIOLIN, dark=1400, bright=4200, attack=0.08),
    "tremolo strings": replace(_ENSEMBLE, tremolo=13.0, attack=0.05),
    "pizzicato strings": StringVoice(0.5, 0.12, 0.3, 0.06),
    "orchestral harp": _HARP,
    "timpani": StruckVoice(
        (1, 1.5, 1.98, 2.44, 2.9), (1, 0.6, 0.35, 0.2, 0.1), 1.6, 0.3, strike=0.1
    ),
    "string ensemble 2": replace(_ENSEMBLE, attack=0.25, dark=1000, bright=3500),
    "choir aahs": ToneVoice("sawtooth", 0.12, 0.35, 4000, 6000, 10, 3, 6.0, 0.01, _AAH),
    "voice oohs": ToneVoice("sawtooth", 0.1, 0.3, 3000, 4500, 10, 3, 6.0, 0.01, _OOH),
    "orchestra hit": ToneVoice("sawtooth", 0.005, 0.3, 2000, 7000, 0, 3, 7.0, decay=0.7),
    "tuba": replace(_BRASS, dark=450, bright=1500, attack=0.06),
    "trombone": replace(_BRASS, dark=700, bright=3200),
    "french horn": replace(_BRASS, dark=600, bright=1900, attack=0.06),
    "muted trumpet": replace(_BRASS, formants=((1800.0, 700.0, 1.0), (4000.0, 1500.0, 0.5))),
    "brass section": replace(_BRASS, players=3, spread=6.0),
    "oboe": ToneVoice("double reed", 0.03, 0.08, 2500, 5500, 10),
    "english horn": ToneVoice("double reed", 0.04, 0.1, 1600, 4000, 10),
    "bassoon": ToneVoice("double reed", 0.03, 0.08, 900, 2600, 6),
    "clarinet": ToneVoice("square", 0.03, 0.08, 1500, 4200, 4),
    "pan flute": replace(_FLUTE, noise=0.16),
    "blown bottle": replace(_FLUTE, noise=0.22),
    "shakuhachi": replace(_FLUTE, noise=0.2, vibrato=22),
    "recorder": replace(_FLUTE, vibrato=6, noise=0.02),
    "whistle": ToneVoice("triangle", 0.03, 0.08, 5000, 9000, 18, noise=0.02),
    "ocarina": ToneVoice("triangle", 0.03, 0.08, 2000, 4000, 10),
    "square lead": ToneVoice("square", 0.008, 0.08, 2500, 7000),
    "choir pad": ToneVoice("sawtooth", 0.3, 0.8, 4000, 5000, 6, 3, 6.0, 0.0, _AAH),
    "bowed pad": replace(_PAD, formants=_BOW),
    "sitar": StringVoice(3.0, 1.6, 0.08, 0.005),
    "banjo": StringVoice(0.8, 0.45, 0.1, 0.01),
    "shamisen": StringVoice(0.7, 0.4, 0.1, 0.01),
    "koto": StringVoice(2.2, 0.8, 0.1, 0.015),
    "kalimba": StruckVoice((1, 5.4, 14.5), (1, 0.2, 0.05), 1.2, 0.5, strike=0.06),
    "bagpipe": ToneVoice("double reed", 0.03, 0.05, 4000, 8000),
    "fiddle": _VIOLIN,
    "shanai": ToneVoice("double reed", 0.03, 0.08, 3000, 7000, 14),
    "steel drums": StruckVoice((1, 2, 3, 4.1), (1, 0.7, 0.35, 0.15), 1.4, 0.3, strike=0.03),
    "agogo": StruckVoice((1, 1.48, 2.6, 4.1), (1, 0.6, 0.4, 0.2), 0.7, 0.3, strike=0.05),
    "woodblock": StruckVoice((1, 2.76, 5.4), (1, 0.4, 0.2), 0.15, 0.3, strike=0.1),
    "taiko drum": StruckVoice((1, 1.59, 2.14, 2.65), (1, 0.5, 0.3, 0.2), 1.0, 0.3, strike=0.2),
    "melodic tom": StruckVoice((1, 1.59, 2.14, 2.65), (1, 0.4, 0.3, 0.2), 0.6, 0.3, strike=0.15),
    "synth drum": StruckVoice((1, 2.2), (1, 0.3), 0.5, 0.3, strike=0.1),
}

# Programs that are noise without a pitch: bands of it [Hz].
_NOISES = {
    "reverse cymbal": (2500.0, 14_000.0),
    "guitar fret noise": (1500.0, 7000.0),
    "breath noise": (600.0, 5000.0),
    "seashore": (200.0, 3000.0),
    "helicopter": (60.0, 900.0),
    "applause": (800.0, 5000.0),
    "gunshot": (100.0, 6000.0),
}


@dataclass(frozen=True, slots=True)
class InstrumentNote:
    """All parameters of a note's sound; equal ones are synthesised once.

    Attributes:
        program: General MIDI program, or `audio.parts.DRUMS`.
        pitch: MIDI pitch, or key of a drum.
        strength: 0 to 1, in steps.
        seconds: for which it is held, in steps; 0 for a drum.
    """

    program: int
    pitch: int
    strength: float
    seconds: float


def instrument_note(program: int, pitch: int, velocity: int, seconds: float) -> InstrumentNote:
    """Return the parameters of a note that is held for a time [s]."""
    strength = round(velocity / 127 * _STRENGTHS) / _STRENGTHS
    steps = max(round(min(seconds, _longest(program)) / _LENGTH_STEP), 1)
    held = steps * _LENGTH_STEP if _longest(program) else 0.0
    return InstrumentNote(program, pitch, strength, held)


def _longest(program: int) -> float:
    """Return the time beyond which it does not matter how long a note is held [s]."""
    if program == DRUMS:
        return 0.0
    if INSTRUMENTS[program] in _NOISES:
        return LONGEST_NOTE
    voice = voice_of_program(program)
    if isinstance(voice, StruckVoice) and not voice.release:
        return 0.0
    return _LONGEST_STRING if isinstance(voice, StringVoice) else LONGEST_NOTE


def voice_of_program(program: int) -> Voice:
    """Return the voice of a program."""
    return _VOICES.get(INSTRUMENTS[program], _FAMILIES[program // FAMILY_SIZE])


def instrument_sound(note: InstrumentNote) -> Signal:
    """Return a note from its onset on, all of like loudness, with peaks of 1 at most: (N,)."""
    rng = seeded(note.program, note.pitch, f"{note.strength:.3f}")
    if note.program == DRUMS:
        index = min(max(note.pitch - LOWEST_DRUM_KEY, 0), len(KIT) - 1)
        # A stroke's peak is pressed into its body, as the tape of a studio does.
        signal = np.tanh(_DRUM_DRIVE * normalized(KIT[index](note.strength, rng)))
    else:
        signal = _melodic(note, rng)
    signal = without_rumble(signal)
    fade = min(_FADE, signal.size)
    signal[signal.size - fade :] *= np.cos(0.5 * np.pi * np.arange(fade) / fade) ** 2
    signal = _levelled(signal)
    # The onset must be detectable on its sample.
    signal[0] = np.copysign(max(abs(signal[0]), _MIN_ONSET), signal[0])
    return signal


def _melodic(note: InstrumentNote, rng: np.random.Generator) -> Signal:
    frequency = frequency_of(note.pitch)
    held = max(int(note.seconds * SAMPLE_RATE), 64)
    band = _NOISES.get(INSTRUMENTS[note.program])
    if band is not None:
        t = np.arange(held) / held
        return band_noise(held, band, rng) * np.sin(np.pi * np.sqrt(t))
    voice = voice_of_program(note.program)
    if isinstance(voice, ToneVoice):
        return sustained_tone(voice, frequency, held, note.strength, rng)
    if isinstance(voice, StruckVoice):
        return struck_tone(voice, frequency, held, note.strength, rng)
    held = min(held, int(_LONGEST_STRING * SAMPLE_RATE))
    samples = held + int(_STRING_RELEASE * SAMPLE_RATE)
    signal = plucked_string(voice, frequency, samples, note.strength, rng)
    signal[held:] *= np.exp(-SILENCE_EXPONENT * np.arange(samples - held) / (samples - held))
    return signal


def _levelled(signal: Signal) -> Signal:
    """Return a sound whose loudest stretch has the usual level, or whose peak is 1 at most."""
    count = max(signal.size // _LOUDNESS_WINDOW, 1)
    size = min(signal.size, count * _LOUDNESS_WINDOW)
    power = (signal[:size].reshape(count, -1) ** 2).mean(axis=1).max()
    if not power:
        return normalized(signal)
    levelled = signal * (_LOUDNESS / float(np.sqrt(power)))
    peak = float(np.abs(levelled).max())
    return np.asarray(levelled / max(peak / _MOST_PEAK, 1.0))
