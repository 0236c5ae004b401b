"""Minds: anxiety, attention, glances and the choice of behaviours, by laws and by measure."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.characters.behaviours.movement_behaviours import WanderAround
from pipeline.simulation.characters.behaviours.registry import (
    IMPLEMENTATIONS,
    behaviour_number,
    load_implementations,
)
from pipeline.simulation.characters.mind.perception import (
    ANXIETY,
    MEMORY_SPAN,
    Glances,
    exposure,
    freshness,
    next_anxiety,
)
from pipeline.simulation.characters.person_record import HAND, PELVIS, SHOULDERS
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
from pipeline.spec.behaviour import FORMS, NAMES, Urge
from pipeline.spec.scene_library import library
from pipeline.spec.scene_loader import load_scene
from tests.simulation.characters.mind_scenes import (
    behaviours_of,
    channel,
    simulation,
    steps,
    troupe,
)

pytestmark = pytest.mark.slow


def test_every_behaviour_has_a_model_an_implementation_and_a_scene() -> None:
    load_implementations()
    assert set(IMPLEMENTATIONS) == {Urge, *FORMS.values()}
    assert tuple(FORMS) == NAMES[1:]
    text = "".join(path.read_text() for path in sorted(library().glob("*.yaml")))
    assert {key for key in FORMS if f"{{{key}: " in text} == set(FORMS)


def test_numbered_behaviours_share_the_number_of_their_kind() -> None:
    assert behaviour_number("comfort 2") == behaviour_number("comfort") == NAMES.index("comfort")
    assert behaviour_number("") == -1


def test_anxiety_grows_with_distance_and_trait_and_falls_by_a_closed_form_in_a_hug() -> None:
    distances = np.linspace(ANXIETY.safe, ANXIETY.exposed, 9)
    far = [next_anxiety(0.2, 0.5, d, False, 1.0) for d in distances]
    assert all(np.diff(far) > 0.0)
    rises = [next_anxiety(0.2, trait, 5.0, False, 1.0) for trait in (0.3, 0.9)]
    assert 0.2 < rises[0] < rises[1]
    assert next_anxiety(0.2, 0.0, 100.0, False, 1.0) == 0.2
    assert next_anxiety(0.9, 1.0, 100.0, False, 1e3) == 1.0
    assert next_anxiety(0.8, 1.0, 9.0, True, 2.0) == pytest.approx(
        0.8 * math.exp(-2.0 * ANXIETY.hug)
    )
    assert exposure(ANXIETY.safe) == 0.0
    assert exposure(ANXIETY.exposed) == 1.0


def test_glance_rate_grows_with_priority() -> None:
    def glance_count(priority: float) -> int:
        glances = Glances(3, np.random.Generator(np.random.PCG64(1)))
        count, before = 0, False
        for k in range(600):
            glances.look(0.1 * k, 0.1, np.array([0.0, 0.0, priority]), 1, -1)
            aside = glances.at == 2
            count, before = count + (aside and not before), aside
        return count

    counts = [glance_count(p) for p in (0.0, 0.1, 0.3, 0.9)]
    assert counts[0] == 0
    assert counts[1] >= 3
    assert all(np.diff(counts) > 0)


def test_characters_out_of_view_are_forgotten() -> None:
    cast = """
- {name: anna, character: child, at: [0, 0], traits: {}, behaviours: [{wander: 0}]}
- {name: ball, character: ball, at: [-6, 0]}
"""
    made = simulation(cast, 1)
    characters = troupe(made)
    assert characters.minds is not None
    memory = characters.minds.minds[0].memory
    characters.minds.think(0, 0.0)
    assert not memory.in_view[1]
    seen = float(memory.seen[1])
    assert freshness(seen, MEMORY_SPAN / 2) == pytest.approx(0.5)
    assert freshness(seen, MEMORY_SPAN) == 0.0
    characters.persons["gaze"][0, 0] = math.pi
    characters.minds.think(0, 0.0)
    assert memory.in_view[1]


@pytest.mark.parametrize(
    ("behaviour", "where", "message"),
    [
        ("{attachment: nobody}", "behaviours[0].attachment", "nobody in the cast is called"),
        ("{attachment: one}", "behaviours[0].attachment", "cannot do that to itself"),
        ("{play: mum}", "behaviours[0].play", "name a ball"),
        ("{fight: ball}", "behaviours[0].fight", "name a child, an adult or a ragdoll"),
    ],
)
def test_behaviours_with_unsuitable_targets_are_rejected(
    behaviour: str, where: str, message: str
) -> None:
    cast = f"""
- {{name: one, character: child, behaviours: [{behaviour}]}}
- {{name: mum, character: adult, at: [3, 0]}}
- {{name: ball, character: ball, at: [5, 0]}}
"""
    with pytest.raises(SceneError) as caught:
        read_scene(f"pronk: 1\ncast:\n{cast}")
    assert where in str(caught.value)
    assert message in str(caught.value)


def test_minds_of_things_and_urges_without_a_mind_are_refused() -> None:
    with pytest.raises(SceneError, match="does not act"):
        read_scene("pronk: 1\ncast:\n- {character: ball, traits: {}}")
    script = "script:\n- {at: 1, who: a, do: {urge: {play: 1}}}"
    with pytest.raises(SceneError, match="does only what it is told"):
        read_scene(f"pronk: 1\ncast:\n- {{name: a, character: child}}\n{script}")
    misspelt = script.replace("play", "pley")
    with pytest.raises(SceneError, match="no behaviour is called 'pley'"):
        read_scene(f"pronk: 1\ncast:\n- {{name: a, character: child, traits: {{}}}}\n{misspelt}")


def test_scripts_override_minds_and_urges_bias_them() -> None:
    cast = """
- {name: one, character: child, at: [0, 0], behaviours: [{approach: ball, distance: 1}]}
- {name: ball, character: ball, at: [7, 0]}
"""
    script = """
script:
- {at: 1, who: one, do: {go_to: [1, 3]}}
- {at: 7, who: one, do: {urge: {approach: -2}}}
"""
    did, places = [], []
    for characters in steps(simulation(cast, 9, script)):
        did.append(characters.minds.minds[0].doing)  # type: ignore[union-attr]
        places.append(characters.persons[0].at.copy())
    a_second = len(did) // 9
    assert did[a_second // 2] == "approach"
    assert did[2 * a_second] == ""
    assert min(math.dist(place, (1.0, 3.0)) for place in places) < 0.15
    assert did[int(6.9 * a_second)] == "approach"
    assert did[8 * a_second] == ""


def test_a_blow_causes_withdrawal_from_the_striker() -> None:
    cast = "- {name: one, character: child, traits: {}, behaviours: [{wander: 0}]}\n"
    cast += "- {name: two, character: child, at: [0.8, 0]}"
    made = simulation(cast, 1.5)
    characters = troupe(made)
    made.step()
    characters.arrays.owners[0].pain = 2.0
    minds = characters.minds
    assert minds is not None
    minds.minds[0].feel_blow(2.0, 1, 0.01)
    characters.arrays.owners[0].pain = 0.0
    gaze = []
    for _ in steps(made):
        gaze.append(abs(float(characters.persons[0].gaze[0])))
    assert characters.persons[0].at[0] < -0.25
    # It turns a shoulder to the striker, and looks where it goes.
    assert 0.6 < abs(characters.persons[0].heading) < 1.3
    assert max(gaze[: len(gaze) // 2]) > 0.5 * np.pi


@pytest.mark.parametrize("seed", [1, 2])
def test_withdrawal_avoids_obstacles(seed: int) -> None:
    cast = "- {name: one, character: child, traits: {}, behaviours: [{wander: 0}]}\n"
    cast += "- {name: two, character: child, at: [0.8, 0]}\n"
    cast += "- {name: wheel, character: merry-go-round, at: [-1.9, 0]}"
    made = simulation(cast, 1.5, f"seed: {seed}")
    characters = troupe(made)
    made.step()
    minds = characters.minds
    assert minds is not None
    minds.minds[0].feel_blow(2.0, 1, 0.01)
    nearest = math.inf
    for _ in steps(made):
        x, z = characters.persons[0].at
        nearest = min(nearest, math.hypot(x + 1.9, z))
    assert nearest > 1.5
    # The person still moves away from the striker, slowly until it has turned its head.
    assert math.hypot(x - 0.8, z) > 1.15


def test_wandering_avoids_occupied_places() -> None:
    cast = "- {name: one, character: child, at: [3, 0], behaviours: [{wander: 3.5}]}\n"
    cast += "- {name: carousel, character: merry-go-round, at: [0.9, 0]}"
    made = simulation(cast, 1.0)
    characters = troupe(made)
    made.step()
    minds = characters.minds
    assert minds is not None
    mind = minds.minds[0]
    stroll = mind.behaviours["wander"]
    assert isinstance(stroll, WanderAround)
    room = mind.surroundings.radius[1] + mind.body_radius
    for _ in range(60):
        stroll.end(mind)
        mind.now += 20.0
        stroll.motor(mind)
        mind.now += 20.0
        stroll.motor(mind)
        assert math.dist(stroll.goal, (0.9, 0.0)) > room


@pytest.mark.slow
def test_a_running_hug_hurts_only_in_slapstick() -> None:
    cast = """
- {name: dad, character: adult, at: [0, 0], traits: {}, behaviours: [{comfort: kid}]}
- {name: kid, character: child, at: [6, 0.5], heading_deg: 180, slapstick: SLAP,
   traits: {speed: 1, anxiety: 1}, behaviours: [{attachment: dad, urge: 1}]}
"""
    for slapstick in (False, True):
        did, fastest, hugged = set[str](), 0.0, False
        for characters in steps(simulation(cast.replace("SLAP", str(slapstick).lower()), 9)):
            minds = characters.minds
            assert minds is not None
            did |= {mind.doing for mind in minds.minds}
            hugged = hugged or minds.minds[1].is_hugging
            fastest = max(fastest, float(np.hypot(*characters.persons[1].velocity)))
        assert fastest > 2.0
        assert ("withdrawal" in did) == slapstick
        assert hugged or slapstick


def test_a_step_back_is_slow_with_the_eyes_on_what_is_faced() -> None:
    made = simulation("- {name: one, character: adult}", 3)
    controller = troupe(made).dispatcher.controllers[0]
    record, fastest = controller.record, 0.0
    controller.go(-2.0, 0.0)
    record.has_facing, record.facing = True, 0.0
    controller.look_at(np.array([2.0, 1.5, 0.0]))
    for _ in steps(made):
        fastest = max(fastest, float(np.hypot(*record.velocity)))
        assert abs(float(record.heading)) < 0.1
        assert abs(float(record.gaze[0])) < 0.2
    assert record.at[0] < -0.5
    assert fastest < 0.45


def test_hands_that_hug_a_small_child_lie_on_its_back() -> None:
    cast = """
- {name: mum, character: adult, at: [0, 0], heading_deg: 120, traits: {},
   behaviours: [{comfort: kid}]}
- {name: kid, character: child, scale: 0.9, at: [4, 0], heading_deg: 180,
   traits: {anxiety: 1, speed: 0.5}, behaviours: [{attachment: mum, urge: 1}]}
"""
    held, heights = 0, list[Array]()
    for characters in steps(simulation(cast, 8)):
        view, minds = characters.dispatcher.view, characters.minds
        assert minds is not None
        kid = next(mind for mind in minds.minds if mind.controller.name == "kid")
        kid.anxiety = 0.5
        held = held + 1 if kid.is_hugging else 0
        # The first second is that in which arms close.
        if held > 96:
            hands = view.nodes(view.owner("mum"))[[HAND, HAND + 1]]
            child = view.nodes(view.owner("kid"))
            low, high = child[PELVIS, 1], child[SHOULDERS, 1]
            heights.append((hands[:, 1] - low) / (high - low))
    # Between waist and neck.
    assert len(heights) > 96
    assert 0.2 < np.min(heights) < np.max(heights) < 1.0


SEEDS = [pytest.param(seed, marks=pytest.mark.nightly) for seed in range(1, 11)]


@pytest.mark.parametrize("seed", SEEDS)
def test_anxious_children_of_the_schoolyard_return_home(seed: int) -> None:
    scene = load_scene(library() / "schoolyard.yaml", [f"seed={seed}"])
    take = simulate(scene)
    anxiety, distance = channel(take, "small.anxiety"), channel(take, "small.distance")
    gaze, did = channel(take, "small.gaze"), behaviours_of(take, "small")
    # Characters are numbered in the order of their names.
    mother = sorted(member.name for member in scene.characters).index("mother")
    dt = 90.0 / len(anxiety)
    # An anxious child returns home and hugs until it is calm.
    returns = [k for k in range(1, len(did)) if did[k] == "attachment" != did[k - 1]]
    ends = [k for k in range(1, len(did)) if did[k - 1] == "attachment" != did[k]]
    soothed = [k for k in ends if anxiety[k] < 0.15 and distance[k] < 1.5]
    left = 0
    for k in soothed:
        after = distance[k : k + int(15.0 / dt)]
        left += bool(after.size and after.max() > 3.0)
    assert returns
    assert min(anxiety[k] for k in returns) > 0.3
    assert len(soothed) >= 2
    assert left >= 2
    # In between it plays.
    assert sum(name == "play" for name in did) * dt > 10.0
    # It looks back more often the farther it is.
    away = np.array([name in ("play", "carry") for name in did])
    begins = np.append(False, (gaze[1:] == mother) & (gaze[:-1] != mother))
    near, far = away & (distance < 4.0), away & (distance >= 4.0)
    rates = [float(begins[where].sum() / (where.sum() * dt)) for where in (near, far)]
    assert rates[1] > 1.3 * rates[0]
