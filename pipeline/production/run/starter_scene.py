"""Starter scene: the commented scene that `pronk new` writes."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

from pipeline.atomic_file import write_if_changed
from pipeline.errors import StoreError, UsageError
from pipeline.spec.scene_library import name_fault

TEXT = """\
# yaml-language-server: $schema=scene.schema.json
# (write that file with: pronk schema > scene.schema.json; editors then complete every word)
#
# {title}: a scene for pronk. Lengths are metres, times seconds.
#   pronk check {file}                          is it right?
#   pronk render {file} --preset draft          a quick film, in out/{name}/
#   pronk render {file} --set fps=30            any word can be changed from outside
pronk: 1                       # version of the language
title: "{title}"
fps: 24                        # or 25, 30, 60, "30000/1001"
duration: 4                    # or frames: 96
seed: 1                        # another number, another ground

terrain:
  kind: hills                  # flat, hills, fractal
  height: 0.8                  # from the lowest point to the highest
  spacing: 5                   # from hill to hill
  material: grass              # grass, moss, dry soil, sand, snow, rock, ...
  unsteppable_slope_deg: 38    # no foot is put on anything steeper

cast:
  - name: bug
    figure: beetle             # from pronk's library, or a figure file beside this one
    at: [-1, 0]                # x and z of where it starts
    heading_deg: 0             # 0 looks along +X, 90 along -Z
    scale: 0.6
    material: blue chitin      # green, brown, black, red chitin, brass, wood, ...
    walk:
      gait: tripod             # tripod, trot, wave
      speed: 0.7               # give two of speed, cycle and stride, or none

camera: {{follow: bug, view: three-quarter}}    # three-quarter, side, front, back, top
light: {{sun: {{hour: 17, day: 172, latitude_deg: 48}}}}
film: {{preset: preview}}        # draft, preview, final
"""


FORBIDDEN_CHARACTERS = '/\\:*?"<>|{}#'
"""Characters with a meaning to some file system or to YAML."""


def write_starter(name: str, folder: Path) -> Path:
    """Write a starter scene called `name` into `folder` and return its file.

    Raises:
        UsageError: the name is not fit for a file, or the file exists.
        StoreError: it cannot be written.
    """
    stem = name.removesuffix(".yaml")
    odd = not stem.isprintable() or set(stem) & set(FORBIDDEN_CHARACTERS)
    if odd or name_fault(stem) is not None or stem.startswith("-"):
        raise UsageError(f"'{name}' is no name for a scene; letters, digits, - and _ are")
    path = folder / f"{stem}.yaml"
    title = stem.replace("_", " ").capitalize()
    text = TEXT.format(name=stem, file=shlex.quote(path.name), title=title)
    if os.path.lexists(path):
        raise UsageError(f"{path.name}: is there already; choose another name")
    try:
        write_if_changed(path, text.encode())
    except OSError as error:
        raise StoreError(f"{path}: cannot be written ({error.strerror})") from error
    return path
