"""Cries and hugs in events, score and sound, on the frame of their onset."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import mido
import numpy as np
import pytest

from audio.general_midi import program_number
from audio.midi_file import write_midi
from audio.notes import notes_of
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.characters.mind.mind_scheduler import (
    DISTRESS_ANXIETY,
    DISTRESS_CRY_INTERVAL,
)
from pipeline.simulation.characters.step_report import CRY, loudness
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import SoundEvent, Take
from pipeline.spec import Scene, read_scene
from tests.simulation.characters.mind_scenes import troupe

pytestmark = pytest.mark.slow

BLOW = """pronk: 1
duration: 2
cast:
- {name: a, character: adult, at: [0, 0]}
- {name: ball, character: ball, scale: 2, at: [-1.5, 1.2, 0], velocity: [14, 1, 0]}
"""

HUG = """pronk: 1
duration: 5
cast:
- {name: a, character: adult, at: [0, 0]}
- {name: b, character: child, at: [1.6, 0.1], heading_deg: 180}
script:
- {at: 0.2, who: b, do: {hug: a}}
"""

LOST = """pronk: 1
duration: 16
terrain: {kind: flat, size: [30, 30]}
cast:
- {name: mum, character: adult, at: [0, 0], traits: {}, behaviours: [{comfort: kid}]}
- {name: kid, character: child, at: [9, 0], traits: {anxiety: 0.5, speed: 0.3},
   behaviours: [{attachment: mum}]}
"""


def events_of(take: Take, cause: str) -> list[SoundEvent]:
    return [event for event in take.events if event.cause == cause]


def run_scene(text: str) -> tuple[Scene, Take, list[tuple[int, str, str, str]]]:
    """Return a scene, its take, and its signals: step, kind, performer, other."""
    scene = read_scene(text)
    simulation, happened = Simulation(scene), []
    while not simulation.finished:
        simulation.step()
        step = simulation.step_number
        happened += [(step, s.kind, s.who, s.other) for s in simulation.signals]
    return scene, simulation.take(), happened


def assert_in_midi(scene: Scene, take: Take, event: SoundEvent, name: str, path: Path) -> None:
    """Check that the note of an event starts at its frame's tick, with its cause's instrument."""
    score, _ = build_score(scene, take, ShotBuilder(scene, take).poses)
    (note,) = [
        n for n in notes_of(score) if (n.event.cause, n.event.frame) == (event.cause, event.frame)
    ]
    assert note.onset * scene.rate == event.frame - 1
    write_midi(score, path / "score.mid")
    file = mido.MidiFile(path / "score.mid")
    ticks = []
    for track in file.tracks:
        now, programs = 0, {}
        for message in track:
            now += message.time
            if message.type == "program_change":
                programs[message.channel] = message.program
            elif message.type == "note_on" and message.velocity:
                if programs.get(message.channel) == program_number(name):
                    ticks.append(now)
    # 40 ticks a frame at 24 frames a second.
    assert (event.frame - 1) * 40 in ticks


def test_a_hard_blow_is_cried_out_on_its_frame(tmp_path: Path) -> None:
    scene, take, happened = run_scene(BLOW)
    first, *_ = events_of(take, "cry")
    blow = next(c for c in take.contacts if {c.performer, c.other} == {"a", "ball"})
    assert first.frame == 1 + math.ceil((blow.step + blow.fraction) / take.header.steps)
    assert (first.who, first.other, first.part) == ("a", "ball", "a.head")
    assert next(signal[0] for signal in happened if signal[1] == "cry") == first.step
    row = first.track[0]
    head = take.positions[row, [node.name for node in take.nodes].index("a.head")]
    assert math.dist(first.place, head) < 0.25
    assert CRY.faintest < first.strength <= CRY.loudest
    assert_in_midi(scene, take, first, "choir aahs", tmp_path)


def test_cries_grow_louder_with_pain_up_to_a_limit() -> None:
    strengths = [loudness(pain) for pain in (0.0, 0.5, 1.0, 2.0)]
    assert strengths[0] == CRY.faintest
    assert all(a < b for a, b in pairwise(strengths))
    assert loudness(100.0) == CRY.loudest


def test_a_hug_is_heard_once_when_the_arms_have_closed(tmp_path: Path) -> None:
    scene, take, happened = run_scene(HUG)
    (event,) = events_of(take, "hug")
    ((step, _, hugger, hugged),) = [signal for signal in happened if signal[1] == "hug"]
    assert (event.step, event.who, event.other) == (step, hugger, hugged) == (step, "b", "a")
    assert event.frame == 1 + math.ceil(step / take.header.steps)
    assert 0.1 < event.strength < 0.6
    assert_in_midi(scene, take, event, "voice oohs", tmp_path)


@pytest.mark.parametrize(
    ("options", "cause", "is_heard"),
    [
        ("{cry: {heard: false}}", "cry", False),
        ("{cry: {above: 100}}", "cry", False),
        ("{cry: {who: b}}", "cry", False),
        ("{cry: {who: a, above: 0.5}}", "cry", True),
        ("{hug: {heard: false}}", "hug", False),
        ("{hug: {who: 'b*'}}", "hug", True),
    ],
)
def test_detection_options_select_cries_and_hugs(options: str, cause: str, is_heard: bool) -> None:
    base = BLOW.replace("{name: ball", "{name: b") if cause == "cry" else HUG
    _, take, _ = run_scene(f"{base}sound: {{detect: {options}}}\n")
    assert bool(events_of(take, cause)) == is_heard


def test_a_distressed_child_cries_on_the_way_back_and_not_in_arms() -> None:
    simulation = Simulation(read_scene(LOST))
    minds = troupe(simulation).minds
    assert minds is not None
    kid = next(mind for mind in minds.minds if mind.controller.name == "kid")
    kid.anxiety = 0.9
    levels, hugging = [], []
    while not simulation.finished:
        simulation.step()
        levels.append(kid.anxiety)
        hugging.append(kid.is_hugging)
    take = simulation.take()
    cries = [event for event in events_of(take, "cry") if event.who == "kid"]
    steps = take.header.steps * float(take.header.rate)
    times = np.array([event.step / steps for event in cries])
    home = hugging.index(True) / steps
    assert len(cries) >= 2
    assert times.min() < 0.5
    assert (np.diff(times) >= DISTRESS_CRY_INTERVAL - 1e-9).all()
    assert times.max() < home
    assert all(levels[event.step - 1] >= DISTRESS_ANXIETY for event in cries)
    # Anxiety in arms decays to this level.
    assert min(levels[hugging.index(True) :]) < 0.2


PLAY = """pronk: 1
duration: 12
terrain: {kind: flat, size: [30, 30]}
cast:
- {name: kid, character: child, at: [0, 0], traits: {}, behaviours: [{play: ball}]}
- {name: ball, character: ball, at: [1.5, 0.5]}
"""

CHASE = """pronk: 1
duration: 4
terrain: {kind: flat, size: [30, 30]}
cast:
- {name: hare, character: child, at: [0, 0], traits: {}, behaviours: [{flee: hound}]}
- {name: hound, character: adult, at: [2, 0], traits: {}, behaviours: [{approach: hare}]}
"""


def test_a_child_at_play_laughs_now_and_then() -> None:
    _, take, happened = run_scene(PLAY)
    laughs = events_of(take, "laugh")
    assert 1 <= len(laughs) <= 4
    assert {event.who for event in laughs} == {"kid"}
    assert [event.step for event in laughs] == [s for s, kind, *_ in happened if kind == "laugh"]
    steps = take.header.steps * float(take.header.rate)
    assert (np.diff([event.step / steps for event in laughs]) >= 3.0).all()
    assert not events_of(take, "gasp")


def test_who_takes_to_flight_gasps_once() -> None:
    _, take, _ = run_scene(CHASE)
    gasp, *others = events_of(take, "gasp")
    assert (gasp.who, gasp.other, gasp.part) == ("hare", "hound", "hare.head")
    assert gasp.frame == 1 + math.ceil(gasp.step / take.header.steps)
    assert not others
    assert not events_of(take, "laugh")
