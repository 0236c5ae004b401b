"""Errors of the sound writers.

AudioError
├── GridError              a frame rate has no exact MIDI grid
├── ScoreError             an event or a length that a score cannot hold
├── SoundFileError         a file could not be written or read
├── NotationError          sheet music cannot be written
├── SoundFontError         a SoundFont cannot be played: its file is wrong
└── SoundFontPlayerError   SoundFonts cannot be played at all
"""

from __future__ import annotations


class AudioError(Exception):
    """Root of all errors that `audio` raises on purpose."""


class GridError(AudioError):
    """A frame rate has no grid on which every frame is a whole tick."""


class ScoreError(AudioError):
    """A score holds something that cannot be written, such as an event after its end."""


class SoundFileError(AudioError):
    """A file could not be written or read; an earlier file is untouched."""


class NotationError(AudioError):
    """Sheet music cannot be written, because what writes it is missing or fails."""


class SoundFontError(AudioError):
    """A SoundFont is missing or damaged."""


class SoundFontPlayerError(AudioError):
    """The player of SoundFonts is not installed or does not work."""
