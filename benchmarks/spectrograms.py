"""Spectrograms: the picture of steps and blows in docs/sound.md.

Each panel is one sound: 0.6 s to the right, 60 Hz to 16 kHz upward in octaves, 70 dB from dark to
light.

    python benchmarks/spectrograms.py docs/sound_spectrograms.png
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from audio.synthesis import SoundParameters, synthesize
from audio.time_grid import SAMPLE_RATE
from render.lettering import FOLDER, FONTS

STEPS = ("soil", "grass", "sand", "gravel", "snow", "water", "wood", "stone")
BLOWS = (
    *(("steel", 0.1), ("glass", 0.1), ("porcelain", 0.1), ("oak", 0.1), ("oak", 0.5)),
    *(("brick", 0.1), ("ice", 0.1), ("rubber", 0.1)),
)
WIDTH, HEIGHT, GAP, TITLE = 170, 150, 8, 18
SECONDS, LOW, HIGH, RANGE_DB = 0.6, 60.0, 16_000.0, 70.0
WINDOW = 1024
COLORS = np.array([[0, 0, 8], [60, 15, 110], [180, 50, 120], [250, 140, 95], [252, 250, 200]])


def panel(sound: np.ndarray) -> np.ndarray:
    """Return the spectrogram of a sound as a picture (HEIGHT, WIDTH, 3)."""
    whole = np.zeros(int(SECONDS * SAMPLE_RATE) + WINDOW)
    whole[: min(sound.size, whole.size)] = sound[: whole.size]
    starts = np.linspace(0, whole.size - WINDOW - 1, WIDTH).astype(int)
    frames = whole[starts[:, None] + np.arange(WINDOW)] * np.hanning(WINDOW)
    power = np.abs(np.fft.rfft(frames, 4 * WINDOW, axis=1)) ** 2
    bins = np.geomspace(LOW, HIGH, HEIGHT) * 4 * WINDOW / SAMPLE_RATE
    level = 10 * np.log10(power[:, bins.astype(int)].T[::-1] + 1e-12)
    share = np.clip(1.0 + (level - level.max()) / RANGE_DB, 0.0, 1.0) * (len(COLORS) - 1)
    channels = [np.interp(share, np.arange(len(COLORS)), COLORS[:, c]) for c in range(3)]
    return np.stack(channels, axis=-1).astype(np.uint8)


def sound_of(cause: str, material: str, surface: str, size: float) -> np.ndarray:
    """Return one sound, near."""
    return synthesize(
        SoundParameters(cause, material, surface, size, 0.8, 1.0, 0.0, 0.0, 0.0, variant=2), 1
    )


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    usual = Path(tempfile.gettempdir()) / "sound_spectrograms.png"
    parser.add_argument("path", type=Path, nargs="?", default=usual)
    path = parser.parse_args().path
    steps = [(f"step on {name}", sound_of("footfall", "leather", name, 0.95)) for name in STEPS]
    blows = [
        (f"{material}, {100 * size:g} cm", sound_of("collision", material, "wood", size))
        for material, size in BLOWS
    ]
    columns = 4
    rows = -(-len(steps + blows) // columns)
    size = (columns * (WIDTH + GAP) + GAP, rows * (HEIGHT + TITLE + GAP) + GAP)
    picture = Image.new("RGB", size, (255, 255, 255))
    draw, font = ImageDraw.Draw(picture), ImageFont.truetype(FOLDER / FONTS["sans"], 12)
    for k, (name, sound) in enumerate(steps + blows):
        x = GAP + k % columns * (WIDTH + GAP)
        y = GAP + k // columns * (HEIGHT + TITLE + GAP)
        draw.text((x, y), name, (40, 40, 40), font)
        picture.paste(Image.fromarray(panel(sound)), (x, y + TITLE))
    picture.quantize(128).save(path, optimize=True)
    print(f"{path}: {len(steps)} steps, {len(blows)} blows")


if __name__ == "__main__":
    main()
