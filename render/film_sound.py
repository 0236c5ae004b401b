"""Film sound: the track of a film, encoded along with its pictures."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np

from render.errors import EncodeError
from render.film_codecs import RATE, Sound, SoundCodec


class SoundTrack:
    """The sound of a film, encoded along with the video."""

    def __init__(self, container: Any, sound: Sound, codec: SoundCodec) -> None:
        self._container, self._codec = container, codec
        self._sound = sound
        self._layout = "mono" if len(sound) == 1 else "stereo"
        self._stream = container.add_stream(codec.encoder, rate=RATE, layout=self._layout)
        if codec.bit_rate is not None:
            self._stream.bit_rate = codec.bit_rate
        self._at = 0

    def encode_until(self, seconds: Fraction) -> None:
        """Encode the complete blocks that end before a time."""
        while (self._at + self._codec.block) <= seconds * RATE:
            self._encode(self._codec.block)

    def finish_at(self, seconds: Fraction) -> None:
        """Encode the rest up to a time."""
        self.encode_until(seconds)
        rest = round(seconds * RATE) - self._at
        if rest > 0:
            self._encode(rest)
        self._container.mux(self._stream.encode(None))

    def _encode(self, count: int) -> None:
        block = np.zeros((len(self._sound), count), np.float32)
        piece = self._sound[:, self._at : self._at + count]
        block[:, : piece.shape[1]] = piece
        samples = self._codec.quantized(block)
        frame = av.AudioFrame.from_ndarray(samples, format=self._codec.samples, layout=self._layout)
        # With pts alone the sound is a block late: the time base is needed, too.
        frame.sample_rate, frame.pts, frame.time_base = RATE, self._at, Fraction(1, RATE)
        self._container.mux(self._stream.encode(frame))
        self._at += count


def read_wav(path: Path) -> Sound:
    """Return the samples of a WAV file, (channels, N), -1 to 1."""
    with av.open(str(path)) as container:
        if not container.streams.audio:
            raise EncodeError(f"{path} has no sound")
        stream = container.streams.audio[0]
        channels = stream.codec_context.layout.nb_channels
        if stream.rate != RATE or channels > 2:
            raise EncodeError(
                f"{path} has {stream.rate} Hz and {channels} channels; "
                f"write one or two channels at {RATE} Hz"
            )
        to_float = av.AudioResampler(format="fltp", layout=stream.codec_context.layout, rate=RATE)
        blocks = [
            piece.to_ndarray()
            for frame in container.decode(stream)
            for piece in to_float.resample(frame)
        ]
        return np.concatenate(blocks, axis=1) if blocks else np.zeros((channels, 0), np.float32)
