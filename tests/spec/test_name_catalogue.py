"""The catalogue lists every name that the language accepts, and suggestions name the close ones."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import get_args

import pytest
from typer.testing import CliRunner

from audio.general_midi import DRUMS, INSTRUMENTS
from pipeline.cli import app
from pipeline.commands.completion import MAX_TEXT_LENGTH, completion
from pipeline.errors import SceneError, UsageError
from pipeline.production.run.starter_scene import write_starter
from pipeline.spec import library, read_scene, shipped_scenes
from pipeline.spec.behaviour import NAMES
from pipeline.spec.body import ShapeName
from pipeline.spec.character_kinds import Kind
from pipeline.spec.mood import MOODS
from pipeline.spec.name_catalogue import LIBRARY_GROUP, NAME_KINDS, OWN_GROUP, names_of
from pipeline.spec.script import FORMS, Plain, When
from pipeline.spec.sound_thresholds import Detect
from pipeline.spec.suggestions import close_names, hint
from pipeline.spec.terrain.base import TERRAIN_KINDS, TERRAIN_PRESETS
from pipeline.spec.walk import GaitName
from render.config import LIGHTS, MATERIALS

NAMES_BY_KIND = {
    "figures": [path.stem for path in (library() / "figures").glob("*.yaml")],
    "dances": [path.stem for path in (library() / "dances").glob("*.yaml")],
    "scenes": shipped_scenes(),
    "materials": MATERIALS,
    "terrains": {*TERRAIN_PRESETS, *TERRAIN_KINDS},
    "lights": LIGHTS,
    "gaits": get_args(GaitName),
    "moods": MOODS,
    "verbs": {*FORMS, *get_args(Plain)},
    "behaviours": NAMES,
    "instruments": INSTRUMENTS,
    "drums": DRUMS,
    "causes": Detect.model_fields,
    # The others say more about an event.
    "events": [key for key in When.model_fields if key not in ("within", "act")],
    "characters": get_args(Kind),
    "props": ["box", "ball", "cylinder", "cone", "gear"],
    "groups": ["flock", "school", "swarm", "rain", "fire", "grass"],
}


@pytest.mark.parametrize("kind", NAMES_BY_KIND)
def test_the_catalogue_has_the_names_of_the_registry(kind: str, tmp_path: Path) -> None:
    assert sorted(entry.name for entry in names_of(kind, tmp_path)) == sorted(NAMES_BY_KIND[kind])


@pytest.mark.parametrize("kind", NAME_KINDS)
def test_every_name_is_described_and_groups_stay_together(kind: str, tmp_path: Path) -> None:
    entries = names_of(kind, tmp_path)
    assert entries
    assert [entry.name for entry in entries if not entry.text] == []
    groups = [entry.group for entry in entries]
    changes = sum(a != b for a, b in pairwise(groups))
    assert changes == len(set(groups)) - 1


def test_bodies_are_listed_by_shape_and_layout_with_their_defaults() -> None:
    entries = {
        (entry.group.partition(":")[0], entry.name): entry.text
        for entry in names_of("bodies", Path())
    }
    assert entries["body", "box"].endswith("Keys: hollow, size [0.3, 0.3, 0.3].")
    assert {*get_args(ShapeName), "hull", "mesh"} == {
        name for kind, name in entries if kind == "body"
    }
    layouts = {"wall", "pyramid", "stack", "row", "heap"}
    assert layouts == {name for kind, name in entries if kind == "many"}


def test_own_files_are_listed_by_what_they_hold(tmp_path: Path) -> None:
    (tmp_path / "figures").mkdir()
    figure = (library() / "figures" / "tripod.yaml").read_text("utf-8")
    (tmp_path / "stool.yaml").write_text("# A stool. It walks.\n" + figure)
    (tmp_path / "figures" / "beetle.yaml").write_text(figure)
    (tmp_path / "play.yaml").write_text("pronk: 1\ntitle: A play\ncast: []\n")
    write_starter("hello", tmp_path)
    (tmp_path / "other.yaml").write_text("services: {}\n")
    (tmp_path / "broken.yaml").write_text("figure: [")
    figures = names_of("figures", tmp_path)
    own = {entry.name: entry.text for entry in figures if entry.group == OWN_GROUP}
    assert own["stool"] == "A stool."
    assert own.keys() == {"stool", "beetle"}
    assert "beetle" not in [entry.name for entry in figures if entry.group == LIBRARY_GROUP]
    scenes = names_of("scenes", tmp_path)
    assert [(entry.name, entry.text) for entry in scenes if entry.group == OWN_GROUP] == [
        ("hello", "Hello: a scene for pronk."),
        ("play", "A play"),
    ]


def test_an_unknown_kind_is_refused_with_the_near_one() -> None:
    with pytest.raises(UsageError, match="nothing is listed as 'figurs', did you mean 'figures'"):
        names_of("figurs", Path())


def test_list_prints_kinds_names_and_json() -> None:
    runner = CliRunner()
    kinds = [line.split()[0] for line in runner.invoke(app, ["list"]).stdout.splitlines()]
    assert kinds == list(NAME_KINDS)
    text = runner.invoke(app, ["list", "instruments"]).stdout
    assert "piano:\n  acoustic grand piano   program 1\n" in text
    (line, *_) = runner.invoke(app, ["list", "figures", "--json"]).stdout.splitlines()
    assert json.loads(line).keys() >= {"name", "text", "length", "width", "height", "legs", "mass"}
    lines = runner.invoke(app, ["list", "moods", "--json"]).stdout.splitlines()
    assert [json.loads(line)["name"] for line in lines] == list(MOODS)


@pytest.mark.parametrize(
    ("name", "known", "close"),
    [
        ("scorpoin", NAMES_BY_KIND["figures"], ["scorpion"]),
        ("knee_m", ["knee_r", "knee_l", "hip"], ["knee_l", "knee_r"]),
        ("Sax", INSTRUMENTS, ["alto sax", "tenor sax", "soprano sax", "baritone sax"]),
        ("gren chitin", MATERIALS, ["green chitin"]),
        ("at", ["bat", "horse"], ["bat"]),
        ("zzz", MATERIALS, []),
        ("", MATERIALS, []),
    ],
)
def test_all_close_names_are_found(name: str, known: list[str], close: list[str]) -> None:
    found = close_names(name, known)
    assert sorted(found) == sorted(close)


def test_a_hint_names_the_close_and_the_command_that_lists_the_rest() -> None:
    assert hint("gallop", ["trot", "rotary gallop", "transverse gallop"], "gaits") == (
        "did you mean 'rotary gallop' or 'transverse gallop'? `pronk list gaits` has all 3"
    )
    assert hint("zzz", ["trot"], "gaits", own=["mine"]) == (
        "known here: mine; `pronk list gaits` has all 1"
    )
    assert hint("zzz", ["b", "a"]) == "known: a, b"
    assert hint("zzz", []) == "there are none"
    assert hint("zzz", [f"n{i:03}" for i in range(102)]).endswith("n099 and 2 more")


def completed(words: str, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what bash would offer for the last of the words."""
    environment = {
        "_PRONK_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
    }
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    return CliRunner().invoke(app, prog_name="pronk").stdout.split()


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("pronk figure scor", ["scorpion", "scorched.yaml"]),
        ("pronk check stai", ["stairs"]),
        ("pronk check sub/", ["sub/play.yaml"]),
        ("pronk render s", ["sub/"]),
        ("pronk list m", ["materials", "moods"]),
        ("pronk render stairs --preset d", ["draft"]),
    ],
)
def test_shells_complete_names_and_files(
    words: str, offered: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "play.yaml").write_text("pronk: 1\n")
    (tmp_path / "sub" / "notes.txt").write_text("")
    (tmp_path / "scorched.yaml").write_text("pronk: 1\n")
    assert set(offered) <= set(found := completed(words, monkeypatch))
    start = words.rpartition(" ")[2]
    assert all(name.startswith(start) for name in found)


def test_descriptions_beside_completions_stay_on_one_line() -> None:
    for kind in NAME_KINDS:
        for _, text in completion(kind)(""):
            assert len(text) <= MAX_TEXT_LENGTH
            assert "\n" not in text


@pytest.mark.parametrize(
    ("member", "order", "message"),
    [
        ("", "{grb: kim}", "no order is called 'grb', did you mean 'grab'? `pronk list verbs`"),
        ("", "{zzz: kim}", "no order is called 'zzz', `pronk list verbs` has all"),
        ("", "{}", "needs one of the keys gait, mood, go_to"),
        (", behaviours: [{plya: kim}]", "stop", "no behaviour is called 'plya', did you mean"),
    ],
)
def test_a_mapping_without_a_deciding_key_is_refused_once(
    member: str, order: str, message: str
) -> None:
    with pytest.raises(SceneError) as caught:
        read_scene(
            f"pronk: 1\nframes: 24\ncast: [{{character: child, name: kim{member}}}]\n"
            f"script: [{{at: 0.5, who: kim, do: {order}}}]\n"
        )
    (problem,) = caught.value.problems
    assert message in problem.message


@pytest.mark.parametrize(
    ("block", "name", "kind"),
    [
        ("film: {look: wram}", "warm", "looks"),
        ("light: {weather: rian}", "rain", "weather"),
        ("light: {haze: mit}", "mist", "haze"),
        ("light: {sun: {clouds: cumulos}}", "cumulus", "clouds"),
        ("terrain: {preset: hills, water: lak}", "lake", "water"),
        ("terrain: {preset: hills, water: {waves: rogh}}", "rough", "waves"),
        ("terrain: {preset: hills, scatter: medow}", "meadow", "scatter"),
        ("terrain: {preset: hills, scatter: [oka]}", "oak", "species"),
        ("terrain: {preset: hills, material: gras}", "grass", "materials"),
        ("light: dusc", "dusk", "lights"),
    ],
)
def test_a_misspelt_name_is_answered_with_a_list_that_has_it(
    block: str, name: str, kind: str
) -> None:
    with pytest.raises(SceneError) as error:
        read_scene(f"pronk: 1\nframes: 2\n{block}\ncast: [{{figure: beetle}}]\n")
    message = error.value.problems[0].message
    assert f"did you mean '{name}'" in message
    assert f"`pronk list {kind}` has all" in message
    assert name in [entry.name for entry in names_of(kind, Path())]
