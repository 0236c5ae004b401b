"""Scene and figure files: search order, encodings, and messages for missing files."""

from __future__ import annotations

import pytest

from pipeline.errors import SceneError, UsageError
from pipeline.spec import (
    find_scene,
    library,
    load_figure,
    load_scene,
    read_scene,
    shipped_scenes,
    simulation_key,
)

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: bug}]\n"
FIGURE = "pronk: 1\nfigure:\n  nodes: {head: [0, -1], hip: [0, 0]}\n  chains: [[head, hip]]\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "play.yaml").write_text(SCENE)
    return tmp_path


def problems_of(call, *arguments):
    with pytest.raises(SceneError) as caught:
        call(*arguments)
    return [str(problem).partition("\n")[0] for problem in caught.value.problems]


@pytest.mark.parametrize("place", ["bug.yaml", "figures/bug.yaml"])
def test_a_figure_is_found_beside_the_scene(folder, place):
    (folder / "figures").mkdir()
    (folder / place).write_text(FIGURE)
    assert list(load_scene("play.yaml").figures) == ["bug"]


def test_a_figure_in_the_scene_comes_before_one_beside_it(folder):
    (folder / "bug.yaml").write_text("pronk: 1\nfigure: no figure at all\n")
    own = "figures: {bug: {nodes: {own: [0, 0]}}}\n"
    (folder / "play.yaml").write_text(SCENE + own)
    assert list(load_scene("play.yaml").figures["bug"].nodes) == ["own"]


def test_a_scene_may_have_the_name_of_its_figure(folder):
    (folder / "figures").mkdir()
    (folder / "figures" / "bug.yaml").write_text(FIGURE)
    (folder / "bug.yaml").write_text(SCENE)
    assert list(load_scene("bug.yaml").figures) == ["bug"]
    assert list(load_scene("play.yaml").figures) == ["bug"]


def test_mistakes_in_a_figure_file_have_its_name_and_lines(folder):
    wrong = FIGURE.replace("[head, hip]", "[haed, hip]").replace("nodes: {", "nodes: {a: [x, 0], ")
    (folder / "bug.yaml").write_text(wrong)
    (folder / "play.yaml").write_text(SCENE.replace("1\nc", "-1\nc"))
    assert problems_of(load_scene, "play.yaml") == [
        "play.yaml:2:11: duration: must be greater than 0, is -1",
        "bug.yaml:3:15: figure.nodes.a[0]: should be a number, is the text 'x'",
    ]
    (folder / "bug.yaml").write_text(wrong.replace("x, 0", "1, 0"))
    assert problems_of(load_figure, "bug.yaml") == [
        "bug.yaml:4:13: figure.chains[0][0]: no node is called 'haed', did you mean 'head'?"
    ]


def test_a_material_that_a_figure_file_names_must_be_in_the_scene(folder):
    (folder / "bug.yaml").write_text(FIGURE + "  material: goo\n")
    assert problems_of(load_scene, "play.yaml")[0].startswith(
        "bug.yaml:5:13: figures.bug.material: no material is called 'goo'"
    )
    (folder / "play.yaml").write_text(SCENE + "materials: {goo: {color: '#00ff00'}}\n")
    assert load_scene("play.yaml").figures["bug"].material == "goo"


def test_a_figure_file_that_is_no_yaml_is_reported(folder):
    (folder / "bug.yaml").write_text("figure: [")
    (problem,) = problems_of(load_scene, "play.yaml")
    assert problem.startswith("bug.yaml:1:10: is not YAML: ")


def test_the_message_of_a_missing_figure_names_the_search_places_and_the_nearest_name(folder):
    (folder / "figures").mkdir()
    (folder / "figures" / "bugs.yaml").write_text(FIGURE)
    assert problems_of(load_scene, "play.yaml") == [
        "play.yaml:3:17: cast[0].figure: no figure is called 'bug', did you mean 'bugs'? "
        "`pronk list figures` has all 23 (searched: this file, bug.yaml and figures/bug.yaml "
        "beside it, the library)"
    ]


def test_a_figure_file_is_refused_as_a_scene():
    path = library() / "figures" / "beetle.yaml"
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    (problem,) = caught.value.problems
    assert (problem.line, problem.path) == (4, "figure")
    assert "is a figure, not a scene; pronk figure reports on it" in problem.message


def test_a_figure_file_of_a_newer_version_is_refused(folder):
    (folder / "bug.yaml").write_text(FIGURE.replace("pronk: 1", "pronk: 3"))
    assert problems_of(load_figure, "bug.yaml") == [
        "bug.yaml:1:8: pronk: this pronk reads version 1 of the language, not 3"
    ]


def test_a_folder_is_refused_as_a_scene(folder):
    (folder / "sub").mkdir()
    assert problems_of(load_scene, "sub") == ["sub: is a folder, not a file"]


def test_a_byte_order_mark_and_other_line_breaks_are_accepted():
    text = SCENE + "figures: {bug: {nodes: {own: [0, 0]}}}\n"
    for content in (b"\xef\xbb\xbf" + text.encode(), text.replace("\n", "\r\n").encode()):
        assert read_scene(content).n_frames == 24


def test_all_line_breaks_count_lines():
    for line_break in ("\n", "\r\n", "\r"):
        text = (SCENE + "sead: 1\n").replace("\n", line_break)
        with pytest.raises(SceneError) as caught:
            read_scene(text)
        problem = caught.value.problems[-1]
        assert (problem.line, problem.column, problem.source) == (4, 1, "sead: 1")


def test_find_scene_takes_a_path_a_name_here_and_a_shipped_name(folder, monkeypatch):
    shipped = folder / "shipped"
    shipped.mkdir()
    (shipped / "first_steps.yaml").write_text(SCENE)
    monkeypatch.setattr("pipeline.spec.scene_library.library", lambda: shipped)
    assert shipped_scenes() == ["first_steps"]
    assert find_scene("play.yaml").samefile("play.yaml")
    assert find_scene("play").samefile("play.yaml")
    assert find_scene(str(folder / "play")).samefile("play.yaml")
    for name in ("first_steps", "first_steps.yaml"):
        assert find_scene(name) == shipped / "first_steps.yaml"
    (folder / "first_steps.yaml").write_text(SCENE)
    assert find_scene("first_steps").samefile("first_steps.yaml")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("plya", "no scene is called 'plya', neither in this folder nor among the shipped; did "
         "you mean 'play'? `pronk list scenes` has all 54"),
        ("./plya.yaml", "'./plya.yaml' is no file in {here}, did you mean 'play.yaml'?"),
        ("sub/plya.yaml", "'sub/plya.yaml' is no file in {here}/sub, which holds no YAML files"),
        ("bus/plya.yaml", "'bus/plya.yaml' is no file: there is no folder {here}/bus"),
        ("sub", "'sub' is a folder; give the file of a scene"),
    ],
)  # fmt: skip
def test_a_missing_scene_is_refused_with_a_hint(folder, name, message):
    (folder / "sub").mkdir()
    with pytest.raises(UsageError) as caught:
        find_scene(name)
    assert str(caught.value) == message.format(here=folder.resolve())


@pytest.mark.parametrize("name", ["", "\0", "a\nb", "x" * 5000, "/", "..", "*", "\udcff"])
def test_odd_names_are_refused_without_a_traceback(folder, name):
    with pytest.raises(UsageError):
        find_scene(name)
    with pytest.raises((UsageError, SceneError)):
        load_scene(name)


def test_the_library_has_figures():
    assert (library() / "figures").is_dir()


@pytest.mark.parametrize("path", sorted((library() / "figures").glob("*.yaml")), ids=str)
def test_shipped_figures_load(path):
    assert load_figure(path).nodes


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_load(name):
    assert load_scene(find_scene(name)).n_frames >= 1


def test_a_path_of_a_figure_is_the_same_as_its_name(folder):
    (folder / "bug.yaml").write_text(FIGURE)
    (folder / "sub").mkdir()
    (folder / "sub" / "bug.yaml").write_text(FIGURE.replace("head", "nose"))
    by_name = load_scene("play.yaml")
    for path in ("bug.yaml", "./bug.yaml", "./bug", "sub/../bug.yaml", str(folder / "bug.yaml")):
        (folder / "play.yaml").write_text(SCENE.replace("figure: bug", f"figure: {path}"))
        scene = load_scene("play.yaml")
        assert (list(scene.figures), scene.cast) == (["bug"], by_name.cast)
        assert simulation_key(scene) == simulation_key(by_name)
    (folder / "play.yaml").write_text(
        "pronk: 1\nframes: 24\n"
        "cast: [{figure: sub/bug.yaml}, {figure: bug}, {figure: ./bug.yaml}]\n"
    )
    scene = load_scene("play.yaml")
    assert [member.figure for member in scene.cast] == ["bug_2", "bug", "bug"]
    assert "nose" in scene.figures["bug_2"].nodes
    assert "head" in scene.figures["bug"].nodes


def test_paths_are_those_from_the_folder_of_the_scene(folder, monkeypatch):
    (folder / "sub").mkdir()
    (folder / "bug.yaml").write_text(FIGURE)
    (folder / "play.yaml").write_text(SCENE.replace("figure: bug", "figure: ./bug.yaml"))
    monkeypatch.chdir(folder / "sub")
    assert list(load_scene("../play.yaml").figures) == ["bug"]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("bgu.yaml", "'bgu.yaml' is no file in {here}, did you mean 'bug.yaml'?"),
        ("sub/bug.yaml", "'sub/bug.yaml' is no file in {here}/sub, which holds no YAML files"),
        ("no/bug.yaml", "'no/bug.yaml' is no file: there is no folder {here}/no"),
        ("./sub", "'./sub' is a folder, not a file"),
        ("play.yaml", "'play.yaml' holds no figure; it lacks the key 'figure'"),
    ],
)
def test_a_path_that_leads_to_no_figure(folder, path, message):
    (folder / "sub").mkdir()
    (folder / "bug.yaml").write_text(FIGURE)
    (folder / "play.yaml").write_text(SCENE.replace("figure: bug", f"figure: {path}"))
    assert problems_of(load_scene, "play.yaml") == [
        "play.yaml:3:17: cast[0].figure: " + message.format(here=folder.resolve())
    ]


def test_dances_are_named_by_paths_too(folder):
    (folder / "wave.yaml").write_text((library() / "dances" / "waving.yaml").read_text("utf-8"))
    (folder / "play.yaml").write_text(
        "pronk: 1\nframes: 24\ncast: [{dancer: torso, dance: ./wave.yaml}]\n"
        "script: [{at: 0.5, who: dancer, do: {dance: wave.yaml}}]\n"
    )
    scene = load_scene("play.yaml")
    assert list(scene.dances) == ["wave"]
    assert (scene.cast[0].dance, scene.script[0].do.dance) == ("wave", "wave")
