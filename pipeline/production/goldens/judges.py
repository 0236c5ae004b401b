"""Judging: golden against new, one function a layer, nothing rendered and nothing written."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens import cue_files, film_facts
from pipeline.production.goldens.frame_limits import Limits
from pipeline.production.goldens.golden_content import Content, Picture
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_verdict import Outcome as MotionOutcome
from pipeline.production.goldens.verdict import (
    Box,
    FrameVerdict,
    LayerVerdict,
    Outcome,
    gravest,
)
from pipeline.simulation.take import Take
from render.comparison.flip_metric import flip, judge
from render.comparison.image_statistics import (
    SeedSpread,
    psnr,
    tile_box,
    tile_deviations,
    tile_means,
)

BOXES: Final = 5
"""Tiles that are shown as the worst."""


def judge_motion(golden: Content, take: Take, new: cue_files.Cues) -> LayerVerdict:
    """Judge poses, contacts, sound events, notes and the camera's way."""
    assert golden.motion is not None
    assert golden.cues is not None
    verdict = compare(golden.motion, take)
    same = verdict.outcome is MotionOutcome.IDENTICAL
    other = tuple(cue_files.differences(golden.cues, new, exact=same))
    details = (*str(verdict).splitlines()[1:], *other)
    if verdict.passed and not other:
        outcome = Outcome.IDENTICAL if same else Outcome.WITHIN
        return LayerVerdict("motion", outcome, verdict.rule, tuple(d.strip() for d in details))
    text = verdict.rule
    if verdict.first is not None:
        text = f"first {verdict.moment}: {verdict.first.who} {verdict.first.text}"
    elif other:
        text = other[0]
    kept = tuple(d.strip() for d in details if d.strip() != text)
    return LayerVerdict("motion", Outcome.CHANGED, text, kept)


def judge_film(golden: Content, new: film_facts.FilmFacts, frame: float) -> LayerVerdict:
    """Judge a film whose frames last `frame` seconds by what was decoded of it."""
    assert golden.film is not None
    found = tuple(film_facts.differences(golden.film, new, frame))
    if found:
        return LayerVerdict("film", Outcome.CHANGED, found[0], found[1:])
    counts = f"{len(new.shown)} pictures, {len(new.onsets)} onsets of sound"
    if golden.film == new:
        return LayerVerdict("film", Outcome.IDENTICAL, counts)
    return LayerVerdict("film", Outcome.WITHIN, f"{counts}, clear ones within half a frame")


def judge_frames(golden: Content, new: dict[int, Picture], environment: str) -> LayerVerdict:
    """Judge all frames of a golden.

    Args:
        golden: what is to be.
        new: number -> picture, of the same framing.
        environment: what the pixels of `new` depend on.
    """
    at_home = golden.environment == environment
    verdicts = tuple(
        judge_frame(
            number, picture, new[number], golden.limits, at_home, golden.spreads.get(number)
        )
        for number, picture in golden.frames.items()
    )
    outcome = gravest(verdict.outcome for verdict in verdicts)
    worst = [verdict for verdict in verdicts if verdict.outcome is outcome]
    if outcome is Outcome.IDENTICAL:
        return LayerVerdict("frames", outcome, f"{len(verdicts)} pictures to the bit", (), verdicts)
    most = max(worst, key=lambda verdict: (verdict.tile, verdict.z or 0.0))
    elsewhere = () if at_home else (f"here {environment}, the golden's {golden.environment}",)
    of = f"{len(worst)} of {len(verdicts)} frames, the worst {most.frame}: {most.text}"
    rest = tuple(f"frame {v.frame}: {v.text}" for v in worst if v is not most)
    return LayerVerdict("frames", outcome, of, (*rest, *elsewhere), verdicts)


def judge_frame(
    number: int,
    golden: Picture,
    new: Picture,
    limits: Limits,
    at_home: bool,
    spread: SeedSpread | None,
) -> FrameVerdict:
    """Judge one frame.

    Equal pixels pass. In the environment of the golden FLIP decides, its mean and that of its
    worst tile; it sees edges that moved by a pixel. Elsewhere the noise is another one, and
    what decides is how far the means of tiles lie from those of the golden's seeds, without
    which nobody can tell. Where they are known they decide at home too: they see a light that
    is a little weaker, which in FLIP is less than noise.
    """
    if golden.shape != new.shape:
        text = f"is {new.shape[1]}x{new.shape[0]}, the golden {golden.shape[1]}x{golden.shape[0]}"
        return FrameVerdict(number, Outcome.CHANGED, "size", text, 1.0, 1.0, 0.0)
    if np.array_equal(golden, new):
        return FrameVerdict(number, Outcome.IDENTICAL, "digest", "equal to the bit")
    errors = flip(golden, new)
    tiles = tile_means(errors)
    zs = None if spread is None else tile_deviations(spread, new)
    mean, tile, ratio = float(errors.mean()), float(tiles.max()), psnr(golden, new)
    z = None if zs is None else float(zs.max())
    told = [f"FLIP {mean:.4f} (limit {limits.mean:g}), worst tile {tile:.4f}"]
    told[0] += f" (limit {limits.tile:g})"
    told += [] if z is None else [f"z {z:.1f} (limit {limits.z:g}) in the worst tile"]
    told.append(f"PSNR {ratio:.1f} dB")
    seen = mean > limits.mean or tile > limits.tile
    far = z is not None and z > limits.z
    outcome = Outcome.CHANGED if (at_home and seen) or far else Outcome.WITHIN
    rule = f"FLIP by {judge()}" + (" and z-test" if zs is not None else "")
    if not at_home:
        rule = "z-test, for the environment is another one"
        if zs is None:
            outcome, rule = Outcome.UNJUDGED, "none"
            told.insert(0, "other environment, and no variances are known: calibrate the golden")
    by_z = zs is not None and not (at_home and seen)
    boxes = _boxes(zs if by_z and zs is not None else tiles, golden.shape)
    text = ", ".join(told)
    return FrameVerdict(number, outcome, rule, text, mean, tile, ratio, z, boxes)


def _boxes(tiles: NDArray[np.float64], shape: tuple[int, ...]) -> tuple[Box, ...]:
    order = np.argsort(tiles, axis=None, kind="stable")[::-1][:BOXES]
    places = [divmod(int(k), tiles.shape[1]) for k in order]
    return tuple(
        Box(*tile_box(row, column, shape), round(float(tiles[row, column]), 4))
        for row, column in places
    )
