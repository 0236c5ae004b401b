"""Plot files: a picture as SVG and PNG."""

from __future__ import annotations

import tempfile
from pathlib import Path

import resvg_py
from PIL import ImageFont

from pipeline.atomic_file import write_if_changed
from pipeline.production.run.scene_run import SceneRun


def png_of(svg: str) -> bytes:
    """Return an SVG as PNG, its text set in a font that every machine has."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "font.ttf"
        file.write_bytes(getattr(ImageFont.load_default(16), "font_bytes", b""))
        return bytes(resvg_py.svg_to_bytes(svg_string=svg, font_files=[str(file)], zoom=1.5))


def write_plot(run: SceneRun, kind: str, svg: str) -> tuple[Path, Path]:
    """Write a plot into a scene's folder as SVG and PNG, and return both files."""
    files = write_pictures(run.outputs.folder / f"{run.outputs.name}_{kind}", svg)
    run.records.update(*files)
    return files


def write_pictures(stem: Path, svg: str) -> tuple[Path, Path]:
    """Write a picture as SVG and PNG, named by a path without suffix."""
    files = stem.with_name(f"{stem.name}.svg"), stem.with_name(f"{stem.name}.png")
    write_if_changed(files[0], svg.encode("utf-8"))
    write_if_changed(files[1], png_of(svg))
    return files
