"""What can go wrong in the renderer, as one tree.

RenderError
├── BackendMissing    no variant of Mitsuba works as asked
├── DeviceMemoryShort  a graphics processor has too little memory for the shot
├── ShotError         the shot cannot be drawn: a material is missing, a number is not finite
├── DenoiseError      the denoiser is missing or failed
├── FrameFileError    a picture could not be written or read
└── EncodeError       the film could not be encoded
"""

from __future__ import annotations


class RenderError(Exception):
    """Root of all errors of the renderer; the message says what to do."""


class BackendMissing(RenderError):
    """No variant of Mitsuba works as asked on this machine."""


class DeviceMemoryShort(RenderError):
    """A graphics processor has too little memory for the shot."""


class ShotError(RenderError):
    """The shot cannot be drawn."""


class DenoiseError(RenderError):
    """The denoiser is missing or failed."""


class FrameFileError(RenderError):
    """A picture could not be written or read."""


class EncodeError(RenderError):
    """The film could not be encoded."""
