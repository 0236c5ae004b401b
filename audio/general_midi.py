"""General MIDI: melodic instruments and drums by name.

Source: MMA General MIDI 1991, tables 1 to 3.
"""

from __future__ import annotations

from audio.names import UnknownName, normalized_name

# In the order of the programs, 0 to 127.
INSTRUMENTS: tuple[str, ...] = (
    *("acoustic grand piano", "bright acoustic piano", "electric grand piano", "honky-tonk piano"),
    *("electric piano 1", "electric piano 2", "harpsichord", "clavinet"),
    *("celesta", "glockenspiel", "music box", "vibraphone"),
    *("marimba", "xylophone", "tubular bells", "dulcimer"),
    *("drawbar organ", "percussive organ", "rock organ", "church organ"),
    *("reed organ", "accordion", "harmonica", "tango accordion"),
    *("nylon guitar", "steel guitar", "jazz guitar", "clean guitar"),
    *("muted guitar", "overdriven guitar", "distortion guitar", "guitar harmonics"),
    *("acoustic bass", "fingered bass", "picked bass", "fretless bass"),
    *("slap bass 1", "slap bass 2", "synth bass 1", "synth bass 2"),
    *("violin", "viola", "cello", "contrabass"),
    *("tremolo strings", "pizzicato strings", "orchestral harp", "timpani"),
    *("string ensemble 1", "string ensemble 2", "synth strings 1", "synth strings 2"),
    *("choir aahs", "voice oohs", "synth voice", "orchestra hit"),
    *("trumpet", "trombone", "tuba", "muted trumpet"),
    *("french horn", "brass section", "synth brass 1", "synth brass 2"),
    *("soprano sax", "alto sax", "tenor sax", "baritone sax"),
    *("oboe", "english horn", "bassoon", "clarinet"),
    *("piccolo", "flute", "recorder", "pan flute"),
    *("blown bottle", "shakuhachi", "whistle", "ocarina"),
    *("square lead", "sawtooth lead", "calliope lead", "chiff lead"),
    *("charang lead", "voice lead", "fifths lead", "bass and lead"),
    *("new age pad", "warm pad", "polysynth pad", "choir pad"),
    *("bowed pad", "metallic pad", "halo pad", "sweep pad"),
    *("rain", "soundtrack", "crystal", "atmosphere"),
    *("brightness", "goblins", "echoes", "sci-fi"),
    *("sitar", "banjo", "shamisen", "koto"),
    *("kalimba", "bagpipe", "fiddle", "shanai"),
    *("tinkle bell", "agogo", "steel drums", "woodblock"),
    *("taiko drum", "melodic tom", "synth drum", "reverse cymbal"),
    *("guitar fret noise", "breath noise", "seashore", "bird tweet"),
    *("telephone ring", "helicopter", "applause", "gunshot"),
)

FAMILY_SIZE = 8
FAMILIES = (
    *("piano", "chromatic percussion", "organ", "guitar", "bass", "strings", "ensemble", "brass"),
    *("reed", "pipe", "synth lead", "synth pad", "synth effects", "ethnic", "percussive"),
    "sound effects",
)
"""Families of the instruments: eight programs each, in the order of the programs."""

# Usual ranges of the instruments chosen by default, at sounding pitch. Others stay within the
# middle of the keyboard.
RANGES: dict[str, tuple[int, int]] = {
    "kalimba": (48, 88),
    "xylophone": (53, 96),
    "marimba": (36, 96),
    "vibraphone": (41, 89),
    "celesta": (60, 96),
    "glockenspiel": (67, 96),
    "melodic tom": (36, 79),
    "slap bass 1": (36, 67),
    "slap bass 2": (36, 67),
    "muted guitar": (40, 83),
    "clavinet": (36, 89),
    "muted trumpet": (52, 84),
    "whistle": (67, 96),
}
_DEFAULT_RANGE = (36, 96)

# In the order of the keys, from the lowest.
LOWEST_DRUM_KEY = 35
DRUMS: tuple[str, ...] = (
    *("acoustic bass drum", "bass drum", "side stick", "acoustic snare", "hand clap"),
    *("electric snare", "low floor tom", "closed hi-hat", "high floor tom", "pedal hi-hat"),
    *("low tom", "open hi-hat", "low-mid tom", "hi-mid tom", "crash cymbal 1", "high tom"),
    *("ride cymbal 1", "chinese cymbal", "ride bell", "tambourine", "splash cymbal", "cowbell"),
    *("crash cymbal 2", "vibraslap", "ride cymbal 2", "hi bongo", "low bongo"),
    *("mute hi conga", "open hi conga", "low conga", "high timbale", "low timbale"),
    *("high agogo", "low agogo", "cabasa", "maracas", "short whistle", "long whistle"),
    *("short guiro", "long guiro", "claves", "hi wood block", "low wood block"),
    *("mute cuica", "open cuica", "mute triangle", "open triangle"),
)

_PROGRAMS = {normalized_name(name): program for program, name in enumerate(INSTRUMENTS)}
_DRUM_KEYS = {normalized_name(name): key for key, name in enumerate(DRUMS, LOWEST_DRUM_KEY)}


def program_number(name: str) -> int:
    """Return the General MIDI program of an instrument, 0 to 127.

    Raises:
        UnknownName: no instrument has this name; the message names the nearest.
    """
    if normalized_name(name) not in _PROGRAMS:
        raise UnknownName("instrument", name, INSTRUMENTS)
    return _PROGRAMS[normalized_name(name)]


def drum_key(name: str) -> int:
    """Return the key of a drum on the drum channel, 35 to 81.

    Raises:
        UnknownName: no drum has this name; the message names the nearest.
    """
    if normalized_name(name) not in _DRUM_KEYS:
        raise UnknownName("drum", name, DRUMS)
    return _DRUM_KEYS[normalized_name(name)]


def usual_range(program: int) -> tuple[int, int]:
    """Return the lowest and the highest usual pitch of an instrument."""
    return RANGES.get(INSTRUMENTS[program], _DEFAULT_RANGE)
