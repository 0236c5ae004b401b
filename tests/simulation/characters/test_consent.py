"""Consent: people accept or decline by mood, attachment and what they do, and tell why."""

from __future__ import annotations

import pytest

from pipeline.simulation.characters.mind.consent import Consent
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from tests.simulation.characters.scripted_people import troupe_of

SCENE = """pronk: 1
duration: 1.5
cast:
  - {name: ben, character: adult, at: [0, 0]}
  - {name: mia, character: child, at: [0.75, 0], heading_deg: 180, traits: {anxiety: 0.1},
     behaviours: [{attachment: mum}, {carry: doll}]}
  - {name: mum, character: adult, at: [0, 4]}
  - {name: doll, character: ragdoll, at: [5, 5]}
script:
  - {at: 0.1, who: ben, do: {hug: mia}}
  - {when: {failed: ben, act: hug}, who: ben, do: {express: sadness}}
"""


def mind_of(simulation: Simulation) -> Mind:
    scheduler = troupe_of(simulation).minds
    assert scheduler is not None
    (mind,) = scheduler.minds
    return mind


def test_mood_attachment_and_occupation_decide() -> None:
    simulation = Simulation(read_scene(SCENE))
    mind = mind_of(simulation)
    consent, (ben, mum, doll) = Consent(mind), (mind.number(n) for n in ("ben", "mum", "doll"))
    assert consent.refusal(ben) == ""
    mind.anxiety = 0.9
    assert consent.refusal(ben) == "is anxious, and ben is no caregiver"
    assert consent.refusal(mum) == ""
    mind.doing = "flee 2"
    assert consent.refusal(mum) == "is fleeing"
    mind.attention.fears[ben] = 0.5
    assert consent.refusal(ben) == "is afraid of ben"
    mind.attention.fears[ben], mind.anxiety, mind.doing = 0.0, 0.0, ""
    assert consent.refusal_to_give(mum, doll) == "wants to keep it"
    assert consent.refusal_to_give(mum, ben) == ""


@pytest.mark.parametrize("is_afraid", [True, False])
def test_one_that_is_afraid_declines_a_hug_with_a_note_and_an_event(is_afraid: bool) -> None:
    simulation = Simulation(read_scene(SCENE))
    mind = mind_of(simulation)
    while not simulation.finished:
        if is_afraid:
            mind.attention.fears[mind.number("ben")] = 0.9
        simulation.step()
    orders = [order for order in simulation.take().orders if order.who == "ben"]
    hug, more = orders[0], orders[1:]
    if is_afraid:
        assert (hug.outcome, hug.reason) == ("given up", "mia is afraid of ben, and declines")
        assert len(more) == 1
    else:
        assert hug.outcome != "given up"
