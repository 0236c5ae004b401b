"""Judges: verdicts on layers, one function each, without rendering or writing."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens import cue_facts, film_facts
from pipeline.production.goldens.golden_card import Limits
from pipeline.production.goldens.golden_content import Content, Picture
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_marks import frames_differ, marks_of
from pipeline.production.goldens.motion_verdict import MotionOutcome
from pipeline.production.goldens.verdict import (
    Box,
    FrameVerdict,
    LayerVerdict,
    Outcome,
    gravest_outcome,
)
from pipeline.simulation.take import Take
from render.comparison.flip_metric import flip, judge
from render.comparison.image_statistics import (
    SeedSpread,
    exposure_change,
    psnr,
    region_deviation,
    tile_box,
    tile_deviations,
    tile_means,
)

MAX_BOXES: Final = 5
"""Number of worst tiles shown."""

_EARLIER: Final = (
    "recorded by an earlier version, without {}, which are not checked; "
    "pronk golden approve adds them"
)


def judge_motion(golden: Content, take: Take, new: cue_facts.Cues) -> LayerVerdict:
    """Return the verdict on poses, contacts, sound events, notes and the camera."""
    assert golden.motion is not None
    assert golden.cues is not None
    verdict = compare(golden.motion, take)
    same = verdict.outcome is MotionOutcome.IDENTICAL
    crossing = not same and frames_differ(golden.motion.marks, marks_of(take))
    other = tuple(cue_facts.cue_differences(golden.cues, new, exact=same, crossing=crossing))
    earlier = () if golden.cues.look else (_EARLIER.format("settings, shapes and lens"),)
    details = (*str(verdict).splitlines()[1:], *other, *earlier)
    if verdict.passed and not other:
        outcome = Outcome.IDENTICAL if same and golden.cues.look else Outcome.WITHIN
        return LayerVerdict("motion", outcome, verdict.rule, tuple(d.strip() for d in details))
    text = verdict.rule
    if verdict.first is not None:
        text = f"first {verdict.moment}: {verdict.first.who} {verdict.first.text}"
    elif other:
        text = other[0]
    kept = tuple(d.strip() for d in details if d.strip() != text)
    return LayerVerdict("motion", Outcome.CHANGED, text, kept)


def judge_film(golden: Content, new: film_facts.FilmFacts, frame: float) -> LayerVerdict:
    """Return the verdict on a decoded film whose frames last `frame` seconds."""
    assert golden.film is not None
    found = tuple(film_facts.film_differences(golden.film, new, frame))
    known = golden.film.sound is not None or new.sound is None
    earlier = () if known else (_EARLIER.format("loudness and exact onsets"),)
    if found:
        return LayerVerdict("film", Outcome.CHANGED, found[0], (*found[1:], *earlier))
    counts = f"{len(new.shown)} pictures, {len(new.onsets)} onsets of sound"
    if golden.film == new:
        return LayerVerdict("film", Outcome.IDENTICAL, counts)
    if earlier:
        text = f"{counts}, clear ones within half a frame"
        return LayerVerdict("film", Outcome.WITHIN, text, earlier)
    return LayerVerdict("film", Outcome.WITHIN, f"{counts}, equal in time and loudness")


def judge_frames(golden: Content, new: dict[int, Picture], environment: str) -> LayerVerdict:
    """Return the verdict on all frames of a golden.

    Args:
        golden: expected frames.
        new: number -> picture, of the same framing.
        environment: `Backend.key` of `new`.
    """
    same_environment = golden.environment == environment
    verdicts = tuple(
        judge_frame(
            number,
            picture,
            new[number],
            golden.limits,
            same_environment,
            golden.spreads.get(number),
        )
        for number, picture in golden.frames.items()
    )
    outcome = gravest_outcome(verdict.outcome for verdict in verdicts)
    worst = [verdict for verdict in verdicts if verdict.outcome is outcome]
    if outcome is Outcome.IDENTICAL:
        return LayerVerdict("frames", outcome, f"{len(verdicts)} pictures to the bit", (), verdicts)
    most = max(worst, key=lambda verdict: (verdict.tile, verdict.z or 0.0))
    elsewhere = (
        () if same_environment else (f"here {environment}, the golden's {golden.environment}",)
    )
    text = f"{len(worst)} of {len(verdicts)} frames, the worst {most.frame}: {most.text}"
    rest = tuple(f"frame {v.frame}: {v.text}" for v in worst if v is not most)
    return LayerVerdict("frames", outcome, text, (*rest, *elsewhere), verdicts)


def judge_frame(
    number: int,
    golden: Picture,
    new: Picture,
    limits: Limits,
    same_environment: bool,
    spread: SeedSpread | None,
) -> FrameVerdict:
    """Return the verdict on one frame.

    Equal pixels pass. In the environment of the golden the FLIP error decides, by its mean and its
    worst tile; it detects edges that moved by a pixel. Elsewhere the noise differs, and a z-test of
    the means of tiles and regions against those of the golden's seeds decides; without seeds there
    is no verdict. Where seeds are known the z-test decides in the golden's environment too: it
    detects slightly weaker lights, whose FLIP error is below the noise. So does the exposure, which
    needs no seeds.
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
    z = None
    if spread is not None and zs is not None:
        z = max(float(zs.max()), region_deviation(spread, new))
    exposure = exposure_change(golden, new)
    texts = [f"FLIP {mean:.4f} (limit {limits.mean:g}), worst tile {tile:.4f}"]
    texts[0] += f" (limit {limits.tile:g})"
    texts += [] if z is None else [f"z {z:.1f} (limit {limits.z:g}) in the worst tile or region"]
    texts.append(_exposure_text(golden, new, exposure, limits.exposure))
    texts.append(f"PSNR {ratio:.1f} dB")
    flip_exceeds = mean > limits.mean or tile > limits.tile
    light_exceeds = abs(exposure) > limits.exposure
    z_exceeds = z is not None and z > limits.z
    if light_exceeds:
        # It says most in plain words.
        texts.insert(0, texts.pop(-2))
    by_noise = same_environment or z is not None
    changed = (same_environment and flip_exceeds) or z_exceeds or (by_noise and light_exceeds)
    outcome = Outcome.CHANGED if changed else Outcome.WITHIN
    rule = f"FLIP by {judge()}" + (" and z-test" if zs is not None else "")
    if not same_environment:
        rule = "z-test, for the environment is another one"
        if zs is None:
            outcome, rule = Outcome.UNJUDGED, "none"
            texts.insert(0, "other environment, and no variances are known: calibrate the golden")
    by_flip = zs is None or (same_environment and flip_exceeds)
    boxes = _boxes(tiles if by_flip or zs is None else zs, golden.shape)
    text = ", ".join(texts)
    return FrameVerdict(number, outcome, rule, text, mean, tile, ratio, z, exposure, boxes)


def _exposure_text(golden: Picture, new: Picture, exposure: float, limit: float) -> str:
    """Return the change of exposure as text, relative and absolute."""
    levels = float(new.mean()) - float(golden.mean())
    fate = "brighter" if exposure > 0 else "darker"
    return f"{abs(exposure):.3f} stops {fate} (limit {limit:g}; {levels:+.2f} of 255)"


def _boxes(tiles: NDArray[np.float64], shape: tuple[int, ...]) -> tuple[Box, ...]:
    order = np.argsort(tiles, axis=None, kind="stable")[::-1][:MAX_BOXES]
    places = [divmod(int(k), tiles.shape[1]) for k in order]
    return tuple(
        Box(*tile_box(row, column, shape), round(float(tiles[row, column]), 4))
        for row, column in places
    )
