"""Scenes and figures in files: where they are found and what is said when they are not."""

from __future__ import annotations

import pytest

from pipeline.errors import SceneError, UsageError
from pipeline.spec import find_scene, library, load_figure, load_scene, read_scene, shipped_scenes

SCENE = "pronk: 1\nduration: 1\ncast: [{figure: bug}]\n"
FIGURE = "pronk: 1\nfigure:\n  nodes: {head: [0, -1], hip: [0, 0]}\n  chains: [[head, hip]]\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "play.yaml").write_text(SCENE)
    return tmp_path


def problems_of(call, *given):
    with pytest.raises(SceneError) as caught:
        call(*given)
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


def test_a_scene_may_be_called_like_its_figure(folder):
    (folder / "figures").mkdir()
    (folder / "figures" / "bug.yaml").write_text(FIGURE)
    (folder / "bug.yaml").write_text(SCENE)
    assert list(load_scene("bug.yaml").figures) == ["bug"]
    assert list(load_scene("play.yaml").figures) == ["bug"]


def test_mistakes_in_a_figure_file_carry_its_name_and_lines(folder):
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


def test_a_figure_file_that_is_no_yaml_is_reported_with_the_scene(folder):
    (folder / "bug.yaml").write_text("figure: [")
    (problem,) = problems_of(load_scene, "play.yaml")
    assert problem.startswith("bug.yaml:1:10: is not YAML: ")


def test_a_missing_figure_says_where_was_searched_and_what_is_near(folder):
    (folder / "figures").mkdir()
    (folder / "figures" / "bugs.yaml").write_text(FIGURE)
    assert problems_of(load_scene, "play.yaml") == [
        "play.yaml:3:17: cast[0].figure: no figure is called 'bug', did you mean 'bugs'? (searched:"
        " this file, bug.yaml and figures/bug.yaml beside it, the library)"
    ]


def test_a_figure_file_of_a_newer_version(folder):
    (folder / "bug.yaml").write_text(FIGURE.replace("pronk: 1", "pronk: 3"))
    assert problems_of(load_figure, "bug.yaml") == [
        "bug.yaml:1:8: pronk: this pronk reads version 1 of the language, not 3"
    ]


def test_a_folder_and_an_unreadable_file_are_no_scenes(folder):
    (folder / "sub").mkdir()
    assert problems_of(load_scene, "sub") == ["sub: is a folder, not a file"]


def test_a_byte_order_mark_and_other_line_breaks_are_accepted():
    text = SCENE + "figures: {bug: {nodes: {own: [0, 0]}}}\n"
    for content in (b"\xef\xbb\xbf" + text.encode(), text.replace("\n", "\r\n").encode()):
        assert read_scene(content).n_frames == 24


def test_lines_are_counted_whatever_breaks_them():
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
         "you mean 'play'?"),
        ("./sub/plya.yaml", "there is no file './sub/plya.yaml'; the folder holds no scenes"),
        ("sub", "'sub' is a folder; give the file of a scene"),
    ],
)  # fmt: skip
def test_a_scene_that_is_not_found(folder, name, message):
    (folder / "sub").mkdir()
    with pytest.raises(UsageError) as caught:
        find_scene(name)
    assert str(caught.value) == message


@pytest.mark.parametrize("name", ["", "\0", "a\nb", "x" * 5000, "/", "..", "*", "\udcff"])
def test_odd_names_are_not_found_either(folder, name):
    with pytest.raises(UsageError):
        find_scene(name)
    with pytest.raises((UsageError, SceneError)):
        load_scene(name)


def test_the_library_is_there():
    assert (library() / "figures").is_dir()


@pytest.mark.parametrize("path", sorted((library() / "figures").glob("*.yaml")), ids=str)
def test_shipped_figures_load(path):
    assert load_figure(path).nodes


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_load(name):
    assert load_scene(find_scene(name)).n_frames >= 1
