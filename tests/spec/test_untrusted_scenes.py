"""Untrusted scenes: no file outside of their folder is read, and none that is large."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import Problem, SceneError
from pipeline.foreign_files import confinement, safe_file
from pipeline.spec import file_references as references
from pipeline.spec import library, load_scene
from pipeline.spec.scene_library import files_beside

FIGURE = "pronk: 1\nfigure:\n  nodes: {head: [0, -1], hip: [0, 0]}\n  chains: [[head, hip]]\n"
DANCE = "pronk: 1\ndance:\n  subtasks: [{touch: chest}]\n"
SECRET = "pronk: 1\nsecret: word\n"
MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"

PLAY = "pronk: 1\nduration: 1\n"
SCENES = {
    "terrain.file": PLAY + "terrain: {kind: mesh, file: NAME}\ncast: [{figure: beetle}]\n",
    "terrain.of[0].file": PLAY
    + "terrain: {kind: sum, of: [{kind: image, file: NAME}]}\ncast: [{figure: beetle}]\n",
    "cast[0].body.file": PLAY + "cast: [{body: {shape: mesh, file: NAME}}]\n",
    "cast[0].many.of.file": PLAY
    + "cast: [{many: {layout: stack, of: {shape: mesh, file: NAME}}}]\n",
    "sound.soundfont": PLAY + "cast: [{figure: beetle}]\nsound: {soundfont: NAME}\n",
    "sound.music.file": PLAY + "cast: [{figure: beetle}]\nsound: {music: {file: NAME}}\n",
    "light.hdr.file": PLAY + "cast: [{figure: beetle}]\nlight: {hdr: {file: NAME}}\n",
    "cast[0].figure": PLAY + "cast: [{figure: NAME}]\n",
    "cast[0].dance": PLAY + "cast: [{dancer: {}, dance: NAME}]\n",
}
LEADS_OUT = "leads out of the folder of the scene, which --untrusted refuses"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of a scene; beside it is another one with what it may not read."""
    (tmp_path / "home").mkdir()
    (tmp_path / "scene" / "sub").mkdir(parents=True)
    for name in ("bug.yaml", "ball.obj", "large.obj"):
        (tmp_path / "home" / name).write_text(MESH if name.endswith("obj") else SECRET)
    return tmp_path / "scene"


def problems_of(folder: Path, text: str, name: str) -> list[Problem]:
    """Return the problems of an untrusted scene that names a file."""
    play = folder / "play.yaml"
    play.write_text(text.replace("NAME", f"'{name}'"))
    with pytest.raises(SceneError) as caught:
        load_scene(play, untrusted=True)
    return [*caught.value.problems]


@pytest.mark.parametrize("path", SCENES)
@pytest.mark.parametrize("way", ["../home/bug.yaml", "absolute", "link", "linked folder", "dots"])
def test_no_name_leads_out_of_the_folder(folder: Path, path: str, way: str) -> None:
    outside = folder.parent / "home" / "bug.yaml"
    name = {
        "absolute": str(outside),
        "link": "./link.yaml",
        "linked folder": "linked/bug.yaml",
        "dots": "sub/../../home/bug.yaml",
    }.get(way, way)
    (folder / "link.yaml").symlink_to(outside)
    (folder / "linked").symlink_to(outside.parent)
    (problem,) = [p for p in problems_of(folder, SCENES[path], name) if LEADS_OUT in p.message]
    assert problem.path == path
    assert problem.line >= 3
    assert "secret" not in str(problem)


@pytest.mark.parametrize("name", ["bug", "figures/bug", "linked/bug"])
def test_no_figure_beside_the_scene_is_a_link_out(folder: Path, name: str) -> None:
    (folder / "figures").mkdir()
    (folder / "linked").symlink_to(folder.parent / "home")
    for link in ("bug.yaml", "figures/bug.yaml"):
        (folder / link).symlink_to(folder.parent / "home" / "bug.yaml")
    (problem,) = problems_of(folder, SCENES["cast[0].figure"], name)
    assert f"'{name}' {LEADS_OUT}" in problem.message


def test_a_refusal_does_not_tell_whether_a_file_is_there(folder: Path) -> None:
    for path, text in SCENES.items():
        there, nowhere = (
            [p.message.replace(name, "NAME") for p in problems_of(folder, text, name)]
            for name in ("../home/bug.yaml", "../home/bog.yaml")
        )
        assert there == nowhere, path


def test_suggestions_read_nothing_outside(folder: Path) -> None:
    figure = folder.parent / "home" / "beagle.yaml"
    figure.write_text(FIGURE)
    (folder / "beagle.yaml").symlink_to(figure)
    (folder / "figures").symlink_to(figure.parent)
    (problem,) = problems_of(folder, SCENES["cast[0].figure"], "beagel")
    # Where it would be looked for is a link out itself.
    assert LEADS_OUT in problem.message
    (folder / "figures").unlink()
    (problem,) = problems_of(folder, SCENES["cast[0].figure"], "beagel")
    assert "no figure is called 'beagel'" in problem.message
    assert "beagle" not in problem.message.replace("beagel", "")
    assert "beagle" in files_beside(folder, "figures", "figure")


def test_a_scene_that_is_a_link_out_is_not_read(folder: Path) -> None:
    play = folder / "play.yaml"
    play.symlink_to(folder.parent / "home" / "bug.yaml")
    with pytest.raises(SceneError, match=LEADS_OUT) as caught:
        load_scene(play, untrusted=True)
    assert "secret" not in str(caught.value)


def test_a_mistake_in_a_figure_that_names_a_file_is_no_way_out(folder: Path) -> None:
    # Keys that name files in scenes mean nothing in figure files.
    (folder / "bug.yaml").write_text(FIGURE + "  body: {file: ../home/ball.obj}\n")
    (problem,) = problems_of(folder, SCENES["cast[0].figure"], "bug")
    assert problem.file == str(folder / "bug.yaml")
    (folder / "bug.yaml").write_text("pronk: 1\nfigure: ../home/bug.yaml\n")
    (problem,) = problems_of(folder, SCENES["cast[0].figure"], "bug")
    assert problem.file == str(folder / "bug.yaml")


def test_files_inside_and_the_library_are_read(folder: Path) -> None:
    (folder / "sub" / "ball.obj").write_text(MESH)
    (folder / "ball.obj").symlink_to("sub/ball.obj")
    (folder / "bug.yaml").write_text(FIGURE)
    play = folder / "play.yaml"
    play.write_text(
        PLAY + "cast: [{body: {shape: mesh, file: ball.obj}}, {figure: bug}, {figure: beetle},"
        " {dancer: {}, dance: macarena}]\n"
    )
    # By a linked folder, too, which whoever runs pronk has chosen.
    (folder.parent / "checkout").symlink_to(folder)
    for file in (play, folder.parent / "checkout" / "play.yaml"):
        scene = load_scene(file, untrusted=True)
        assert Path(scene.cast[0].body.file) == folder / "sub" / "ball.obj"
    for name in ("macarena", "horse_gaits"):
        load_scene(library() / f"{name}.yaml", untrusted=True)


def test_large_files_are_refused_with_the_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = safe_file.FileKind("the mesh of a body", 2**30, 2**20)
    monkeypatch.setattr(references, "BODY_MESH", small)
    ball = folder / "ball.obj"
    ball.write_text(MESH + "# " + 2**20 * "x")
    play = folder / "play.yaml"
    play.write_text(SCENES["cast[0].body.file"].replace("NAME", "ball.obj"))
    load_scene(play)
    (problem,) = problems_of(folder, SCENES["cast[0].body.file"], "ball.obj")
    said = "'ball.obj' is larger than 1 MiB, the limit of the mesh of a body with --untrusted"
    assert (problem.message, problem.line) == (said, 3)


def test_kinds_of_files_have_a_lower_limit() -> None:
    kinds = [k for k in vars(safe_file).values() if isinstance(k, safe_file.FileKind)]
    assert len(kinds) == 6
    for kind in kinds:
        assert kind.for_untrusted().max_bytes < kind.max_bytes
        assert kind.for_untrusted().name == f"{kind.name} with --untrusted"


def test_links_out_of_a_folder_are_found(tmp_path: Path) -> None:
    (tmp_path / "out" / "play").mkdir(parents=True)
    (tmp_path / "out" / "play" / "a").symlink_to(".")
    assert confinement.link_out_of(tmp_path / "out" / "play") is None
    assert confinement.link_out_of(tmp_path / "none") is None
    (tmp_path / "out" / "play" / "b").symlink_to("..")
    assert confinement.link_out_of(tmp_path / "out" / "play") == tmp_path / "out" / "play" / "b"
