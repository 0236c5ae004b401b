"""Directed characters: their events are reported, and replay."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.spec import read_scene
from tests.production.direct.direct_client import asked, replayed, session_in

HUG = """\
pronk: 1
duration: 4
cast:
  - {name: mother, character: adult, at: [0.9, 0], heading_deg: 180}
  - {name: child, character: child, at: [-0.5, 0.2]}
"""
BLOW = """\
pronk: 1
duration: 1.2
cast:
  - {name: child, character: child}
  - {name: crate, character: box, scale: 1.5, at: [0, 2.6, 0], velocity: [0, -4, 0]}
"""


@pytest.mark.slow
def test_a_hug_is_reported_when_the_arms_are_closed_and_replays(tmp_path: Path) -> None:
    ask = asked(session_in(tmp_path, read_scene(HUG)))
    ask("command", who="child", do={"hug": "mother"})
    found = ask("step", event=["hug"])
    told = [(one["kind"], one["who"], one["other"]) for one in found["happened"]]
    assert told == [("hug", "child", "mother")]
    places = ask("query", what=["places"])["places"]
    (x, _, z), (u, _, w) = places["child"], places["mother"]
    assert (x - u) ** 2 + (z - w) ** 2 < 0.5**2
    ask("command", who="child", do="let_go")
    kept = ask("end")
    assert replayed(kept["scene"]).digest == kept["digest"]


@pytest.mark.slow
def test_a_blow_is_reported_as_pain_with_its_cause(tmp_path: Path) -> None:
    ask = asked(session_in(tmp_path, read_scene(BLOW)))
    found = ask("step", event=["pain"])
    told = [(one["kind"], one["who"], one["other"]) for one in found["happened"]]
    assert told == [("pain", "child", "crate")]
    assert found["time"] < 1.0
