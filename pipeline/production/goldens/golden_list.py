"""Listing: which goldens there are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline.errors import PronkError
from pipeline.production.goldens.golden_card import Card, read_card
from pipeline.production.goldens.golden_case import found_in


def listed(folder: Path) -> tuple[str, list[dict[str, Any]]]:
    """Return the goldens of a folder, in words and as facts."""
    lines: list[str] = []
    facts: list[dict[str, Any]] = []
    for golden in found_in(folder):
        size = sum(path.stat().st_size for path in golden.path.iterdir())
        try:
            card = read_card(golden.card)
        except PronkError as error:
            lines.append(f"{golden.path.name:<24} {error}")
            facts.append({"scene": golden.path.name, "error": str(error)})
            continue
        lines.append(f"{golden.path.name:<24} {size / 1000:6.0f} kB  {_told(card)}")
        facts.append({"bytes": size, **card.model_dump(mode="json", exclude={"files"})})
    return "\n".join(lines) or f"{folder}: there are no goldens here", facts


def _told(card: Card) -> str:
    words = [", ".join(card.layers)]
    if card.frames is not None:
        width, height = card.frames.size
        numbers = ", ".join(map(str, card.frames.numbers))
        words.append(f"frames {numbers} of {width}x{height}, {card.frames.samples} samples")
        limits = card.limits
        how = f"from {card.calibrated} seeds" if card.calibrated else "not calibrated"
        words.append(f"limits {limits.mean:g}, {limits.tile:g} ({how})")
        words.append(card.environment)
    return "; ".join(words)
