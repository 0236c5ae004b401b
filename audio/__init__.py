"""Score -> MIDI and WAV. Knows nothing of terrain or figures."""

__version__ = "0.1.0"
