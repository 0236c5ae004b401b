"""Code samples: small scenes that between them call all compiled functions."""

from __future__ import annotations

from pathlib import Path

from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene

SAMPLES = (
    # People and what they hold, sit on and stumble over are one function; a mind and what stands
    # in its way.
    "flat, cast: [{character: child, behaviours: [{play: ball}]}, "
    "{name: ball, character: ball, at: [3, 1]}, {character: bench, at: [1.5, 0.3]}]",
    # A body on its own, and bodies that meet one another on even and on uneven ground.
    "flat, cast: [{body: {shape: box}, at: [0, 0.6, 0]}]",
    "flat, cast: [{body: {shape: box, collide: all}, at: [0, 0.6, 0]}]",
    "hills, cast: [{body: {shape: box, collide: all}, at: [0, 0.6, 0]}]",
)
"""Terrains and casts that between them call all compiled functions."""


def code_folder() -> Path:
    """Returns the folder that compiled code is stored in."""
    from pipeline.simulation.dynamics import code_cache

    return code_cache.code_folder()


def compile_all() -> None:
    """Compiles, or loads, the code of every kind of simulation."""
    for sample in SAMPLES:
        simulate(read_scene(f"{{pronk: 1, duration: 1, terrain: {sample}}}"))
