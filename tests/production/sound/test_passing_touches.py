"""Passing touches: a hand that brushes what its dance never touches is on no beat."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pipeline.production.sound.passing_touches import PARTS, is_passing, touched_parts
from pipeline.simulation.take import Take
from pipeline.spec import load_scene
from pipeline.spec.dance import BODY_PLACES
from pipeline.spec.scene_library import SUFFIX, library


def test_every_place_on_the_body_has_a_part() -> None:
    for place in BODY_PLACES:
        assert any(place.startswith(start) for start in PARTS)


@pytest.mark.parametrize(
    ("who", "part", "other", "passing"),
    [
        ("adonis", "hand_r", "yoke", False),
        ("adonis", "adonis.hand_l", "adonis.head", False),
        ("adonis", "hand_r", "forearm_l", True),
        ("adonis", "hand_l", "breast", True),
        ("adonis", "hand_r", "hand_l", True),
        ("adonis", "hand_r", "hermes.forearm_l", False),
        ("adonis", "foot_l", "terrain", False),
        ("crowd", "hand_r", "forearm_l", False),
    ],
)
def test_what_the_macarena_does_not_touch_is_brushed_in_passing(
    take: Take, who: str, part: str, other: str, passing: bool
) -> None:
    touched = touched_parts(load_scene(library() / f"macarena{SUFFIX}"))
    event = replace(take.events[0], who=who, part=part, other=other)
    assert is_passing(event, touched) is passing


def test_hands_that_reach_for_a_place_in_the_air_clap_there(take: Take) -> None:
    scene = load_scene(library() / f"clapping{SUFFIX}")
    touched = touched_parts(scene)
    who = next(iter(touched))
    clap = replace(take.events[0], who=who, part="hand_r", other="hand_l")
    assert not is_passing(clap, touched)
    assert is_passing(replace(clap, other="forearm_l"), touched)
