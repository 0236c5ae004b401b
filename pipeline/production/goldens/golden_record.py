"""Golden record: goldens written for the first time, anew, calibrated, or approved."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from typing import Any

from pipeline.errors import CannotJudge, UsageError
from pipeline.production.goldens.golden_candidate import Candidate, framing_of
from pipeline.production.goldens.golden_card import (
    Limits,
    NoiseLevel,
    noise_level,
    read_card,
)
from pipeline.production.goldens.golden_case import Case, GoldenRenderer, refuse_in_ci
from pipeline.production.goldens.golden_content import (
    Content,
    Picture,
    read_content,
    write_content,
)
from pipeline.production.goldens.motion_golden import golden_of
from pipeline.production.goldens.verdict import LAYERS, Layer
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.progress import Reporter, stage
from render.comparison.image_statistics import seed_spread

MIN_SEEDS = 2
"""Seeds for a calibration: a picture's distance from the others needs two others."""


def record(
    case: Case,
    renderer: GoldenRenderer,
    reporter: Reporter,
    layers: tuple[Layer, ...] | None = None,
    seeds: int = 4,
    again: bool = False,
) -> str:
    """Write the golden of a scene and return a summary.

    Args:
        case: the scene.
        renderer: of its frames.
        reporter: of progress.
        layers: of the golden; None for all.
        seeds: number of seeds that the limits come from; 0 for limits that suit most scenes.
        again: whether to replace an existing golden.

    Raises:
        UsageError: the golden exists, or this runs in continuous integration.
        PronkError: something cannot be made; an earlier golden stays.
    """
    refuse_in_ci("recorded")
    if case.golden.path.exists() and not again:
        raise UsageError(
            f"{case.golden.path}: there is a golden already; look at what pronk golden check says "
            "and approve it, or write it anew with --again"
        )
    content = make_content(case, Candidate(case.scene), renderer, layers or LAYERS, reporter)
    limits = ""
    if content.frames and seeds:
        content, noise = _with_limits(case, content, renderer, seeds, reporter)
        limits = f", limits {_limits_text(noise.limits())} from {seeds} other seeds"
    write_content(content, case.golden)
    size = sum(path.stat().st_size for path in case.golden.path.iterdir()) / 1000
    return f"{case.golden.path}: {', '.join(content.layers)}, {size:.0f} kB{limits}"


def make_content(
    case: Case,
    candidate: Candidate,
    renderer: GoldenRenderer,
    layers: tuple[Layer, ...],
    reporter: Reporter,
) -> Content:
    """Return the content of a golden of the scene as it is now."""
    content = Content(case.name)
    if "motion" in layers:
        with (
            stage(reporter, f"{case.name}: motion", 1) as current,
            compile_progress(reporter, current),
        ):
            content = replace(
                content, motion=golden_of(candidate.take, case.name), cues=candidate.cues
            )
            current.result = f"{len(candidate.take.nodes)} nodes, {len(candidate.cues.notes)} notes"
    if "frames" in layers:
        framing = framing_of(case.scene)
        with (
            stage(reporter, f"{case.name}: frames", len(framing.numbers)) as current,
            compile_progress(reporter, current),
        ):
            frames: dict[int, Picture] = {}
            for number, picture in candidate.frames(framing, renderer.loaded):
                frames[number] = picture
                current.advance(len(frames))
            current.result = f"frames {', '.join(map(str, frames))}"
        content = replace(content, framing=framing, frames=frames, environment=renderer.environment)
    if "film" in layers:
        with stage(reporter, f"{case.name}: film", 1) as current:
            content = replace(content, film=candidate.film)
            current.result = f"{len(candidate.film.onsets)} onsets of sound"
    return content


def calibrate(
    case: Case, renderer: GoldenRenderer, reporter: Reporter, seeds: int, write: bool
) -> str:
    """Return a report on the limits from other seeds, and optionally write them.

    Raises:
        GoldenMissing: there is no golden.
        CannotJudge: it was made in another environment.
        UsageError: it has no frames, the scene has changed, or this runs in continuous integration.
    """
    if write:
        refuse_in_ci("calibrated")
    card = read_card(case.golden.card)
    content = read_content(case.golden, card)
    if content.framing is None:
        raise UsageError(f"{case.golden.path}: has no frames that could be calibrated")
    if content.environment != renderer.environment:
        raise CannotJudge(
            f"{case.golden.path}: was recorded in another environment ({content.environment}), "
            f"whose noise cannot be made here ({renderer.environment})"
        )
    for number, picture in Candidate(case.scene).frames(content.framing, renderer.loaded):
        if (picture != content.frames[number]).any():
            raise UsageError(
                f"{case.golden.path}: frame {number} is no longer what the golden shows; "
                "check and approve it first"
            )
    new, noise = _with_limits(case, content, renderer, seeds, reporter)
    if write:
        write_content(new, case.golden)
    return (
        f"{case.name}: {noise.count} pictures of each frame differ by noise alone, at most "
        f"{noise.mean:.4f} FLIP, {noise.tile:.4f} in the worst tile, {noise.z:.1f} deviations, "
        f"{noise.exposure:.3f} stops\n"
        f"  limits now {_limits_text(card.limits)}\n"
        f"  proposed   {_limits_text(noise.limits())}{' (written)' if write else ', with --write'}"
    )


def _with_limits(
    case: Case, content: Content, renderer: GoldenRenderer, seeds: int, reporter: Reporter
) -> tuple[Content, NoiseLevel]:
    """Return a golden with limits and spreads from other seeds."""
    if seeds < MIN_SEEDS:
        raise UsageError(f"--seeds {seeds}: at least {MIN_SEEDS} are needed to calibrate")
    assert content.framing is not None
    pictures = {number: [picture] for number, picture in content.frames.items()}
    candidate = Candidate(case.scene)
    with stage(reporter, f"{case.name}: seeds", seeds) as current:
        for seed in range(1, seeds + 1):
            for number, picture in candidate.frames(content.framing, renderer.loaded, seed):
                pictures[number].append(picture)
            current.advance(seed)
        noise = noise_level(list(pictures.values()))
        current.result = f"worst tile {noise.tile:.4f}"
    spreads = {number: seed_spread(same) for number, same in pictures.items()}
    return replace(content, limits=noise.limits(), calibrated=seeds, spreads=spreads), noise


def _limits_text(limits: Limits) -> str:
    return (
        f"mean {limits.mean:g}, tile {limits.tile:g}, z {limits.z:g}, exposure {limits.exposure:g}"
    )


def approve(case: Case, layers: tuple[Layer, ...] | None = None) -> str:
    """Replace layers of a golden by those of the last check, without rendering; return a summary.

    Args:
        case: the scene.
        layers: to approve; None for all that differed.

    Raises:
        UsageError: no check has found a difference, or the golden has changed since.
        GoldenMissing: there is no golden.
        StoreError: the golden or the files of the check are damaged.
    """
    refuse_in_ci("approved")
    card = read_card(case.golden.card)
    compared = _read_comparison(case)
    if compared["golden"] != card.seal or compared["made"] != read_card(case.made.card).seal:
        raise UsageError(
            f"{case.golden.path}: is not what the last check compared with; check again"
        )
    chosen = [layer for layer in compared["differ"] if layers is None or layer in layers]
    if not chosen:
        raise UsageError(f"{case.name}: the last check found no difference in these layers")
    made = read_content(case.made, read_card(case.made.card))
    golden = read_content(case.golden, card)
    write_content(_merge_layers(golden, made, chosen), case.golden)
    case.compared.unlink(missing_ok=True)
    shutil.rmtree(case.made.path, ignore_errors=True)
    text = f"{case.golden.path}: approved {', '.join(chosen)}; commit the folder"
    if "frames" in chosen and golden.spreads:
        text += ". Its variances were of the earlier frames: pronk golden calibrate --write"
    return text


def _read_comparison(case: Case) -> dict[str, Any]:
    try:
        members = json.loads(case.compared.read_text(encoding="utf-8"))
        seals = {name: members[name] for name in ("golden", "made")}
        return {**seals, "differ": list(members["differ"])}
    except (OSError, ValueError, KeyError, TypeError):
        raise UsageError(
            f"{case.name}: no check has found a difference that could be approved; call "
            f"pronk golden check {case.arguments} first"
        ) from None


def _merge_layers(golden: Content, made: Content, layers: list[Layer]) -> Content:
    """Return the golden with layers of what was made; its limits stay."""
    if "motion" in layers:
        golden = replace(golden, motion=made.motion, cues=made.cues)
    if "film" in layers:
        golden = replace(golden, film=made.film)
    if "frames" in layers:
        golden = replace(
            golden,
            framing=made.framing,
            frames=made.frames,
            environment=made.environment,
            spreads={},
            calibrated=0,
        )
    return golden
