"""Approving: what the last check made becomes the golden, to the byte as it was looked at."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from typing import Any

from pipeline.errors import UsageError
from pipeline.production.goldens.golden_card import read_card
from pipeline.production.goldens.golden_case import Case
from pipeline.production.goldens.golden_content import Content, read_content, write_content
from pipeline.production.goldens.golden_files import refuse_in_ci
from pipeline.production.goldens.verdict import Layer


def approve(case: Case, layers: tuple[Layer, ...] | None = None) -> str:
    """Make what the last check found to differ the golden; return which layers, in words.

    Nothing is rendered again: what was looked at is what is approved.

    Args:
        case: the scene.
        layers: to approve; all that differed if none are named.

    Raises:
        UsageError: no check has found a difference, or the golden is another one since.
        GoldenMissing: there is no golden.
        StoreError: the golden, or what was made, is damaged.
    """
    refuse_in_ci("approved")
    card = read_card(case.golden.card)
    words = _compared(case)
    if words["golden"] != card.seal or words["made"] != read_card(case.made.card).seal:
        raise UsageError(
            f"{case.golden.path}: is not what the last check compared with; check again"
        )
    chosen = [layer for layer in words["differ"] if layers is None or layer in layers]
    if not chosen:
        raise UsageError(f"{case.name}: the last check found no difference in these layers")
    made = read_content(case.made, read_card(case.made.card))
    golden = read_content(case.golden, card)
    write_content(_merged(golden, made, chosen), case.golden)
    case.compared.unlink(missing_ok=True)
    shutil.rmtree(case.made.path, ignore_errors=True)
    told = f"{case.golden.path}: approved {', '.join(chosen)}; commit the folder"
    if "frames" in chosen and golden.spreads:
        told += ". Its variances were of the earlier frames: pronk golden calibrate --write"
    return told


def _compared(case: Case) -> dict[str, Any]:
    try:
        words = json.loads(case.compared.read_text(encoding="utf-8"))
        return {"golden": words["golden"], "made": words["made"], "differ": list(words["differ"])}
    except (OSError, ValueError, KeyError, TypeError):
        raise UsageError(
            f"{case.name}: no check has found a difference that could be approved; call "
            f"pronk golden check {case.words} first"
        ) from None


def _merged(golden: Content, made: Content, layers: list[Layer]) -> Content:
    """Return the golden with layers of what was made; limits stay as they are."""
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
