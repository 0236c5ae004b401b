"""Stories: names, circles and beats that never come are refused where they stand."""

from __future__ import annotations

import pytest

from pipeline.errors import SceneError
from pipeline.production.direct.session import without_beats
from pipeline.spec import read_scene
from pipeline.spec.digest import simulation_key
from pipeline.spec.scene import Scene
from pipeline.spec.yaml_writer import dump

CAST = """\
pronk: 1
duration: 20
cast:
  - {name: mother, character: adult, at: [2, 0]}
  - {name: anna, character: child}
  - {name: ben, character: child, at: [0, 2]}
  - {name: doll, character: ragdoll, at: [0, 1, 1]}
"""

PLAY = "{name: play, lasts: 2}"


def scene_of(story: str, cast: str = CAST) -> Scene:
    return read_scene(f"{cast}story: {story}\n")


def problems_of(story: str, cast: str = CAST) -> list[str]:
    with pytest.raises(SceneError) as refused:
        scene_of(story, cast)
    return [f"{problem.path}: {problem.message}" for problem in refused.value.problems]


def problem_of(story: str) -> str:
    (problem,) = problems_of(story)
    return problem


def beats(*others: str) -> str:
    return f"{{beats: [{', '.join((PLAY, *others))}]}}"


def after(condition: str, name: str = "next") -> str:
    return f"{{name: {name}, lasts: 2, when: {condition}}}"


@pytest.mark.parametrize(
    ("story", "path", "message"),
    [
        (beats(after("{after: plya}")), "beats[1].when.after", "did you mean 'play'?"),
        (beats(after("{after: play.shove}")), "beats[1].when.after", "no choice of 'play'"),
        (beats(after("{without: plya}")), "beats[1].when.without", "did you mean 'play'?"),
        (beats(after("{near: [ana, ben]}")), "beats[1].when.near[0]", "did you mean 'anna'"),
        (beats(after("{near: [ben, ben]}")), "beats[1].when.near[1]", "name another"),
        (beats(after("{within: 2}")), "beats[1].when.within", "belongs to near"),
        (beats(after("{happened: {hug: [ann, ben]}}")), "beats[1].when.happened.hug[0]", "'anna'"),
        (beats(after("{reached: peace}")), "beats[1].when.reached", "no goal is called 'peace'"),
        (beats(after("{feels: {anna: {joy: 0.5}}}")), "beats[1].when.feels.anna", "no mind"),
        (beats(after("{feels: {doll: {joy: 0.5}}}")), "beats[1].when.feels.doll", "a ragdoll"),
        (beats("{name: play, lasts: 1}"), "beats[1].name", "taken by story.beats[0]"),
        (beats("{name: idle}"), "beats[1]", "has nothing to do"),
        (beats("{name: x, do: [{who: ben, do: stop}]}"), "beats[1]", "is over as soon as it"),
        (beats("{name: x, do: [{who: bem, do: sit}]}"), "beats[1].do[0].who", "did you mean 'ben'"),
        (beats("{name: x, do: [{who: ben, do: {hug: doll}, at: 1, when: {arrived: ben}}]}"),
         "beats[1].do[0]", "at or when"),
        (beats(after("{after: play, without: play}")), "beats[1].when.without", "excludes it"),
        (beats(after("{without: next}")), "beats[1].when.without", "excludes itself"),
        (beats(after("{time: [30, 40]}")), "beats[1].when.time", "the film ends at 20 s"),
        (beats(after("{time: [8, 4]}")), "beats[1].when.time", "write [4, 8]"),
        ("{tension: [[0, 0.1], [0, 0.2]], beats: [" + PLAY + "]}", "tension[1][0]", "after 0 s"),
        ("{relations: [{parent: mother, of: ana}]}", "relations[0].of", "did you mean 'anna'"),
        ("{relations: [{paren: mother, of: anna}]}", "relations[0].paren", "'parent'"),
        ("{relations: [{friend: ben, of: ben}]}", "relations[0].of", "name another"),
        ("{relations: [{friend: doll, of: ben}]}", "relations[0].friend", "a child or an adult"),
        ("{goals: [{name: x, who: ben, wants: {carry: dol}, until: {arrived: ben}}]}",
         "goals[0].wants.carry", "did you mean 'doll'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused_where_it_stands(story: str, path: str, message: str) -> None:
    problem = problem_of(story)
    assert problem.startswith(f"story.{path}: ")
    assert message in problem


def test_a_circle_is_refused_once_with_its_beats() -> None:
    one, two, three = (
        after(f"{{after: {name}}}", own) for own, name in (("a", "b"), ("b", "c"), ("c", "a"))
    )
    later = after("{after: a}", "d")
    problem = problem_of(beats(one, two, three, later))
    assert problem == (
        "story.beats[1].when.after: goes round in a circle: 'a' after 'b' after 'c' after 'a'; "
        "remove one"
    )


def test_a_beat_that_comes_after_two_choices_of_one_beat_never_comes() -> None:
    order = "[{who: ben, do: sit}]"
    choices = f"[{{name: shove, do: {order}}}, {{name: snatch, do: {order}}}]"
    quarrel = f"name: quarrel, choices: {choices}"
    both = after("{after: [quarrel.shove, quarrel.snatch]}")
    assert "'quarrel' is played once" in problem_of(beats(f"{{{quarrel}}}", both))
    assert scene_of(beats(f"{{{quarrel}, repeat: true}}", both))


def test_a_beat_after_one_that_begins_too_late_never_comes() -> None:
    late = after("{time: [10, 20]}", "late")
    problem = problem_of(beats(late, after("{after: late, time: [0, 5]}")))
    assert "comes after 'late', which begins at 10 s or later" in problem


def test_orders_of_beats_are_checked_beside_other_errors() -> None:
    wrong = "{beats: [{name: x, do: [{who: doll, do: sit}]}]}"
    problems = problems_of(wrong, CAST.replace("duration: 20", "duration: -1"))
    assert [problem.partition(":")[0] for problem in problems] == [
        "duration",
        "story.beats[0].do[0].who",
    ]


def test_relations_and_goals_make_minds() -> None:
    story = (
        "{relations: [{parent: mother, of: anna}], "
        "goals: [{name: have, who: ben, wants: {carry: doll}, until: {touch: [ben, doll]}}]}"
    )
    people = {member.name: member for member in scene_of(story).characters}
    assert [type(one).__name__ for one in people["anna"].behaviours] == ["Attachment"]
    assert [type(one).__name__ for one in people["mother"].behaviours] == ["Comfort"]
    assert [type(one).__name__ for one in people["ben"].behaviours] == ["Carry"]
    assert not people["doll"].has_mind
    # So the script may change their urges.
    script = "script: [{at: 1, who: ben, do: {urge: {carry: 0.2}}}]\n"
    assert scene_of(story, CAST + script)


def test_another_program_directs_instead_of_the_beats() -> None:
    scene = scene_of(f"{{relations: [{{parent: mother, of: anna}}], beats: [{PLAY}]}}")
    story = without_beats(scene).story
    assert story is not None
    assert (story.beats, len(story.relations)) == ((), 1)
    assert without_beats(read_scene(CAST)).story is None
    # The directed scene is written as YAML.
    assert "parent: mother" in dump(without_beats(scene), in_full=False)
    events = beats("name: x, do: [{who: ben, do: sit}], until: {arrived: ben}".join("{}"))
    for one in (scene, scene_of(events)):
        assert read_scene(dump(one)).story == one.story


def test_a_story_is_part_of_the_key_of_a_take() -> None:
    keys = {simulation_key(scene_of(beats(after(when)))) for when in ("{}", "{after: play}")}
    keys.add(simulation_key(read_scene(CAST)))
    assert len(keys) == 3


def test_beats_and_choices_name_dances_of_the_library() -> None:
    """They are found as those of a script are."""
    dance = "do: [{who: anna, do: {dance: NAME}}]"
    for beat in (f"lasts: 3, {dance}", f"lasts: 3, choices: [{{name: z, {dance}}}]"):
        story = f"{{beats: [{{name: x, {beat}}}]}}"
        assert list(scene_of(story.replace("NAME", "macarena")).dances) == ["macarena"]
        assert "did you mean 'macarena'" in problem_of(story.replace("NAME", "macarenna"))
