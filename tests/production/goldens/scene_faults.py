"""Faults of timing, cast and film settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.production.goldens.cue_facts import Cues
from pipeline.simulation.take import Take
from tests.production.goldens.golden_faults import Fault, cues, event, moved, word

# --- timing -----------------------------------------------------------------------


def all_events(**steps: Any) -> Callable[[Take], dict[str, Any]]:
    """Return a shift of all sound events."""

    def alter(take: Take) -> dict[str, Any]:
        return {
            "events": tuple(
                replace(e, **{key: getattr(e, key) + by for key, by in steps.items()})
                for e in take.events
            )
        }

    return alter


def note(number: int, **changes: Any) -> Callable[[Cues], Cues]:
    """Return a change of one note."""

    def alter(found: Cues) -> Cues:
        notes = list(found.notes)
        notes[number] = replace(notes[number], **changes)
        return replace(found, notes=tuple(notes))

    return alter


def swapped(*frames: int) -> tuple[int, ...]:
    """Return the order of frames with some of them instead of the first ones."""
    return frames + tuple(range(len(frames) + 1, 13))


TIMING = (
    word("25 frames a second", "film", "fps: 24", "fps: 25", "rate: 25", again=True),
    word("a frame more", "film", "frames: 12", "frames: 13", "pictures decoded", again=True),
    Fault("a picture twice", "film", lambda b: b.altered(order=swapped(1, 2, 2)), "picture 3"),
    Fault("two pictures swapped", "film", lambda b: b.altered(order=swapped(1, 3, 2)), "picture 2"),
    Fault("a picture missing", "film", lambda b: b.altered(order=range(1, 12)), "pictures decoded"),
    Fault("pictures a frame early", "frames", lambda b: b.altered(shown=1)),
    moved("all events a frame late", all_events(step=4, frame=1), "moved to step"),
    moved("all events a quarter of a frame late", all_events(step=1), "moved to step"),
    event("one event a quarter of a frame late", "motion", 3, "moved to step 22", step=22),
    moved(
        "a contact half a step late",
        lambda t: {"contacts": (replace(t.contacts[0], fraction=0.58), *t.contacts[1:])},
        "moved to step 10.58",
    ),
    moved(
        "the motion a row late",
        lambda t: {
            name: np.roll(getattr(t, name), 1, axis=0) for name in ("positions", "rotations")
        },
    ),
    cues("a note a tick late", note(3, tick=241), "tick 241"),
    cues("a note shorter", note(0, ticks=40), "of 40 ticks"),
    word("steps a tenth slower", "motion", "cycle: 0.275", "cycle: 0.3", again=True),
)

# --- cast -------------------------------------------------------------------------


def positions(name: str, by: float, rows: slice = slice(None)) -> Callable[[Take], dict[str, Any]]:
    """Return a shift of a node [m]."""

    def alter(take: Take) -> dict[str, Any]:
        places = take.positions.copy()
        places[rows, [node.name for node in take.nodes].index(name)] += [by, 0, 0]
        return {"positions": places}

    return alter


def turned(take: Take) -> dict[str, Any]:
    """Turn the head by half a degree."""
    j = [node.name for node in take.nodes].index("bug.head.1")
    w, x, y, z = np.moveaxis(take.rotations[:, j], -1, 0)
    c, s = np.cos(np.radians(0.25)), np.sin(np.radians(0.25))
    rotations = take.rotations.copy()
    rotations[:, j] = np.stack(
        [c * w - s * y, c * x + s * z, c * y + s * w, c * z - s * x], axis=-1
    )
    return {"rotations": rotations}


def part(who: str, /, **changes: Any) -> Callable[[Take], dict[str, Any]]:
    """Return a change of a visible part."""
    return lambda take: {
        "parts": tuple(replace(p, **changes) if p.name == who else p for p in take.parts)
    }


def larger(take: Take) -> dict[str, Any]:
    """Make the mesh of the ball two percent larger."""
    number = next(part.seen for part in take.parts if part.name == "ball")
    meshes = list(take.meshes)
    meshes[number] = replace(meshes[number], vertices=meshes[number].vertices * np.float32(1.02))
    return {"meshes": tuple(meshes)}


CAST = (
    moved("a link missing", lambda t: {"parts": t.parts[:4] + t.parts[5:]}, "is gone"),
    moved("a foot 2 cm off", positions("bug.l1.3", 0.02), "bug.l1.3 lies 20 mm off"),
    moved("a foot 2 cm off in one row", positions("bug.r2.3", 0.02, slice(28, 29)), "at step 28"),
    moved("a head turned by half a degree", turned, "bug.head.1 is turned 0.4"),
    moved("a ball 2 % larger", larger, "part ball"),
    moved(
        "a limb hidden from the eighth frame on", part("bug.l2.1", life=(0, 28)), "visible in rows"
    ),
    moved("a renamed part", part("bug.head.1", name="bug.skull"), "part bug.skull is new"),
    word("a bug two percent larger", "motion", "scale: 0.6", "scale: 0.612", again=True),
    word(
        "another figure",
        "motion",
        """figure: beetle
    scale: 0.6
    walk: {gait: tripod, cycle: 0.275, speed: 0.6}""",
        """figure: horse
    scale: 0.3
    walk: {}""",
        "is gone: this node",
        again=True,
    ),
    word("a ball a centimetre aside", "motion", "at: [0.55", "at: [0.56", again=True),
    word("a ball that bounces higher", "motion", "bounciness: 0.5", "bounciness: 0.55", again=True),
    word("another seed", "motion", "seed: 3", "seed: 4", "seed", again=True),
)

# --- film -------------------------------------------------------------------------

FILM = "size: [640, 360], depth: 3"

WORDS = (
    word("film: another shape", "motion", "[640, 360]", "[640, 480]", "film: size is [640, 480]"),
    word("film: larger", "motion", "[640, 360]", "[1280, 720]", "film: size is [1280, 720]"),
    word("film: more samples", "motion", FILM, f"{FILM}, samples: 8", "film: samples is 8"),
    word("film: denoised well", "motion", FILM, f"{FILM}, denoise: high", "film: denoise is high"),
    word("film: full soft light", "motion", FILM, f"{FILM}, soft_light: full", "film: soft_light"),
    word("film: shutter", "motion", FILM, f"{FILM}, shutter_deg: 180", "film: shutter_deg is 180"),
    word("film: moments", "motion", FILM, f"{FILM}, moments: 8", "film: moments is 8"),
    word("film: shorter light paths", "frames", "depth: 3", "depth: 1"),
    word("film: longer light paths", "motion", "depth: 3", "depth: 4", "film: depth is 4"),
    word("film: open EXR frames", "motion", FILM, f"{FILM}, format: exr", "film: format is exr"),
    word("film: another codec", "film", FILM, f"{FILM}, codec: prores", "prores"),
)
