"""Picture notes: what is wrong with the camera or with the light of the pictures."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from pipeline.production.coats.coats import GROWING
from pipeline.production.run.notes import Note, cut_path, place_of
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.spec import Scene
from render.picture_levels import TOP, PictureLevels

BLACK = 0.03
"""Luma below which 99 percent of a black picture lie: nothing can be told apart."""

BLOWN_OUT = 0.6
"""Share of white pixels from which a picture is blown out."""

LEAST_FRAMES = 3
"""Successive pictures from which a level is told; a cut to black for a moment is none."""

MAX_RUNS = 4
"""Runs of frames that a note lists."""


def shooting_notes(scene: Scene, shooting: ShotBuilder) -> list[Note]:
    """Return notes on what the film will not show as asked, before anything is rendered."""
    notes = _camera_notes(scene, shooting), _wading_notes(scene, shooting)
    return [*itertools.chain(*notes), *_coat_notes(scene, shooting)]


def _camera_notes(scene: Scene, shooting: ShotBuilder) -> list[Note]:
    return [
        Note(
            fault.kind,
            "camera",
            fault.part,
            _seconds(scene, fault.frames[0][0]),
            fault.frames[0][0],
            f"{fault.text} in {_listed(fault.frames)}",
            place_of(scene, cut_path(scene, shooting.decisions[fault.cut].source)),
        )
        for fault in shooting.camera_faults()
    ]


def _wading_notes(scene: Scene, shooting: ShotBuilder) -> list[Note]:
    return [
        Note(
            "wades",
            "picture",
            wading.performer,
            _seconds(scene, wading.frame),
            wading.frame,
            f"is {wading.depth:g} m deep in the water, which neither carries nor slows it",
        )
        for wading in shooting.waders()
    ]


def _coat_notes(scene: Scene, shooting: ShotBuilder) -> Iterator[Note]:
    """Yield notes on coats that were asked for and cannot grow."""
    grown = {
        part.performer
        for part in shooting.take.parts
        if shooting.materials[part.material].texture in GROWING
    }
    for i, member in scene.creatures:
        skin = scene.figures[member.figure].skin
        coat = skin.coat if skin else None
        if coat not in (None, "none", "smooth") and member.name not in grown:
            text = (
                f"has no material on which a {coat} coat grows: none has the texture "
                f"{' or '.join(GROWING)}"
            )
            place = place_of(scene, f"cast[{i}].figure")
            yield Note("bare_coat", "picture", member.name, 0.0, 1, text, place)


def level_notes(scene: Scene, frames: Sequence[int], levels: Sequence[PictureLevels]) -> list[Note]:
    """Return notes on pictures that are black or blown out.

    Args:
        scene: of the pictures.
        frames: of the run, ascending.
        levels: of each.
    """
    black = [level.bright < BLACK for level in levels]
    white = [level.white > BLOWN_OUT for level in levels]
    texts = {
        "picture_black": (black, f"99% of the pixels are darker than {BLACK:.0%} of white"),
        "picture_blown_out": (
            white,
            f"more than {BLOWN_OUT:.0%} of the pixels are brighter than {TOP:.0%} of white",
        ),
    }
    return [
        Note(kind, "picture", "film", _seconds(scene, runs[0][0]), runs[0][0], text)
        for kind, (bad, reason) in texts.items()
        if (runs := tuple(_runs(frames, bad)))
        for text in [f"{reason} in {_listed(runs)}"]
    ]


def _runs(frames: Sequence[int], bad: Sequence[bool]) -> Iterator[tuple[int, int]]:
    """Yield first and last of the runs of bad frames; frames that were left out count for none."""
    least = min(LEAST_FRAMES, len(frames))
    for is_bad, group in itertools.groupby(zip(frames, bad, strict=True), lambda pair: pair[1]):
        run = [frame for frame, _ in group]
        if is_bad and len(run) >= least:
            yield run[0], run[-1]


def _seconds(scene: Scene, frame: int) -> float:
    return round(float((frame - 1) / scene.rate), 3)


def _listed(runs: Sequence[tuple[int, int]]) -> str:
    """Return runs of frames in words."""
    shown = ", ".join(f"{a}-{b}" if a < b else f"{a}" for a, b in runs[:MAX_RUNS])
    word = "frame" if len(runs) == 1 and runs[0][0] == runs[0][1] else "frames"
    more = f" and {len(runs) - MAX_RUNS} times more" if len(runs) > MAX_RUNS else ""
    return f"{word} {shown}{more}"
