"""Recording: a scene's golden, written for the first time or anew."""

from __future__ import annotations

from dataclasses import replace

from pipeline.errors import CannotJudge, UsageError
from pipeline.production.goldens.frame_limits import Limits, Seen, seen
from pipeline.production.goldens.golden_card import read_card
from pipeline.production.goldens.golden_case import Case, Lab
from pipeline.production.goldens.golden_content import (
    Content,
    Picture,
    read_content,
    write_content,
)
from pipeline.production.goldens.golden_files import refuse_in_ci
from pipeline.production.goldens.motion_golden import golden_of
from pipeline.production.goldens.sampling_proof import Proof, framing_of
from pipeline.production.goldens.verdict import LAYERS, Layer
from pipeline.production.run.progress import Reporter, stage, step
from render.comparison.image_statistics import seed_spread

LEAST_SEEDS = 2
"""To calibrate with: a picture's distance from the others needs two others."""


def record(
    case: Case,
    lab: Lab,
    reporter: Reporter,
    layers: tuple[Layer, ...] | None = None,
    seeds: int = 4,
    again: bool = False,
) -> str:
    """Write the golden of a scene and return what it holds, in words.

    Args:
        case: the scene.
        lab: renders its frames.
        reporter: is told of it.
        layers: that the golden is to have; all if none are named.
        seeds: the limits are proposed from so many; 0 for limits that suit most scenes.
        again: write it although there is one.

    Raises:
        UsageError: there is a golden already, or this is no place to write one.
        PronkError: something cannot be made; an earlier golden stays as it was.
    """
    refuse_in_ci("recorded")
    if case.golden.path.exists() and not again:
        raise UsageError(
            f"{case.golden.path}: there is a golden already; look at what pronk golden check says "
            "and approve it, or write it anew with --again"
        )
    content = made(case, Proof(case.scene), lab, layers or LAYERS, reporter)
    told = ""
    if content.frames and seeds:
        content, found = _calibrated(case, content, lab, seeds, reporter)
        told = f", limits {_said(found.limits())} from {seeds} other seeds"
    write_content(content, case.golden)
    size = sum(path.stat().st_size for path in case.golden.path.iterdir()) / 1000
    return f"{case.golden.path}: {', '.join(content.layers)}, {size:.0f} kB{told}"


def made(
    case: Case, proof: Proof, lab: Lab, layers: tuple[Layer, ...], reporter: Reporter
) -> Content:
    """Return what a golden of the scene would hold now."""
    content = Content(case.name)
    if "motion" in layers:
        with stage(reporter, f"{case.name}: motion", 1) as current:
            content = replace(content, motion=golden_of(proof.take, case.name), cues=proof.cues)
            current.result = f"{len(proof.take.nodes)} nodes, {len(proof.cues.notes)} notes"
    if "frames" in layers:
        framing = framing_of(case.scene)
        with stage(reporter, f"{case.name}: frames", len(framing.numbers)) as current:
            frames: dict[int, Picture] = {}
            for number, picture in proof.frames(framing, lab.renderer):
                frames[number] = picture
                step(reporter, current, len(frames))
            current.result = f"frames {', '.join(map(str, frames))}"
        content = replace(content, framing=framing, frames=frames, environment=lab.environment)
    if "film" in layers:
        with stage(reporter, f"{case.name}: film", 1) as current:
            content = replace(content, film=proof.film)
            current.result = f"{len(proof.film.onsets)} onsets of sound"
    return content


def calibrate(case: Case, lab: Lab, reporter: Reporter, seeds: int, write: bool) -> str:
    """Say which limits other seeds propose for a scene's golden, and write them if asked to.

    Raises:
        GoldenMissing: there is no golden.
        CannotJudge: it was made in another environment.
        UsageError: it has no frames, the scene has changed, or this is no place to write.
    """
    if write:
        refuse_in_ci("calibrated")
    card = read_card(case.golden.card)
    content = read_content(case.golden, card)
    if content.framing is None:
        raise UsageError(f"{case.golden.path}: has no frames that could be calibrated")
    if content.environment != lab.environment:
        raise CannotJudge(
            f"{case.golden.path}: was recorded in another environment ({content.environment}), "
            f"whose noise cannot be made here ({lab.environment})"
        )
    for number, picture in Proof(case.scene).frames(content.framing, lab.renderer):
        if (picture != content.frames[number]).any():
            raise UsageError(
                f"{case.golden.path}: frame {number} is no longer what the golden shows; "
                "check and approve it first"
            )
    new, found = _calibrated(case, content, lab, seeds, reporter)
    if write:
        write_content(new, case.golden)
    return (
        f"{case.name}: {found.count} pictures of each frame differ by noise alone, at most "
        f"{found.mean:.4f} FLIP, {found.tile:.4f} in the worst tile, {found.z:.1f} deviations\n"
        f"  limits now {_said(card.limits)}\n"
        f"  proposed   {_said(found.limits())}{' (written)' if write else ', with --write'}"
    )


def _calibrated(
    case: Case, content: Content, lab: Lab, seeds: int, reporter: Reporter
) -> tuple[Content, Seen]:
    """Return a golden with limits and spreads from so many other seeds."""
    if seeds < LEAST_SEEDS:
        raise UsageError(f"--seeds {seeds}: at least {LEAST_SEEDS} are needed to calibrate")
    assert content.framing is not None
    pictures = {number: [picture] for number, picture in content.frames.items()}
    proof = Proof(case.scene)
    with stage(reporter, f"{case.name}: seeds", seeds) as current:
        for seed in range(1, seeds + 1):
            for number, picture in proof.frames(content.framing, lab.renderer, seed):
                pictures[number].append(picture)
            step(reporter, current, seed)
        found = seen(list(pictures.values()))
        current.result = f"worst tile {found.tile:.4f}"
    spreads = {number: seed_spread(some) for number, some in pictures.items()}
    new = replace(content, limits=found.limits(), calibrated=seeds, spreads=spreads)
    return new, found


def _said(limits: Limits) -> str:
    return f"mean {limits.mean:g}, tile {limits.tile:g}, z {limits.z:g}"
