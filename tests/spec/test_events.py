"""Events: notes about those that never happened."""

from __future__ import annotations

import pytest

from pipeline.simulation.order_log import _awaited_text
from pipeline.spec.events import EVENTS
from pipeline.spec.script import When

PAIRS = {"touch", "near", "hug"}


@pytest.mark.parametrize("key", EVENTS)
def test_every_event_that_never_happens_is_told_with_its_members(key: str) -> None:
    names = ["ada", "bo"] if key in PAIRS else ["ada"]
    when = When.model_validate({key: names if key in PAIRS else names[0]})
    text = _awaited_text(when)
    assert text.startswith(" and ".join(names))
    assert " never " in f"{text} "
    assert "{" not in text


def test_distances_and_orders_are_told() -> None:
    near = When.model_validate({"near": ["ada", "bo"], "within": 1.5})
    assert _awaited_text(near) == "ada and bo never came within 1.5 m"
    failed = When.model_validate({"failed": "ada", "act": "hug"})
    assert _awaited_text(failed) == "ada never failed to hug"
