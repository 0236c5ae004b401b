"""Edit decision: a cut of a film, and why it is there."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from render.config import Camera


@dataclass(frozen=True, slots=True)
class EditDecision:
    """A cut of a film.

    Attributes:
        camera: its configuration.
        reason: why a director made it, "" for a cut by the author.
        source: number of the camera in the scene that it comes from.
    """

    camera: Camera
    reason: str = ""
    source: int = 0

    @property
    def values(self) -> dict[str, Any]:
        """The camera's values that are not left out, as a scene gives them."""
        values = self.camera.model_dump(exclude_defaults=True, by_alias=True, mode="json")
        return {"start": self.camera.start, **values}

    @property
    def facts(self) -> dict[str, Any]:
        """The decision as plain values."""
        return {**self.values, "reason": self.reason} if self.reason else self.values


def decisions_yaml(decisions: Sequence[EditDecision]) -> str:
    """Return cuts as the block `camera` of a scene, with the reason of each as a comment."""
    lines = ["camera:"]
    for decision in decisions:
        if decision.reason:
            lines.append(f"  # {_one_line(decision.reason)}")
        lines.append(f"  - {_flow(decision.values)}")
    return "\n".join(lines)


def decisions_json(decisions: Sequence[EditDecision]) -> bytes:
    """Return decisions as bytes that `decisions_of_json` reads."""
    plain = [[d.camera.model_dump(mode="json"), d.reason, d.source] for d in decisions]
    return json.dumps(plain).encode()


def decisions_of_json(data: bytes) -> tuple[EditDecision, ...]:
    """Return the decisions that `decisions_json` wrote.

    Raises:
        ValueError: these are none.
    """
    return tuple(
        EditDecision(Camera.model_validate(camera), reason, source)
        for camera, reason, source in json.loads(data)
    )


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _flow(values: dict[str, Any]) -> str:
    """Return values as one line of YAML."""
    text = yaml.safe_dump(
        values, default_flow_style=True, sort_keys=False, allow_unicode=True, width=10**9
    )
    return text.strip()
