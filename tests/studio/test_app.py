"""The routes of the studio: analysis, walks, saving, scenes, and mistakes at their place."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from typing import Any

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.simulation.figure_analysis import build_figure
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.take import Take
from pipeline.spec import library, read_scene
from pipeline.studio import first_frames
from pipeline.studio.app import MAX_PAGES
from pipeline.studio.drawing import DrawnFigure
from pipeline.studio.figure_analysis import with_drawing
from pipeline.studio.figure_text import NEW_FIGURE, figure_of_text
from pipeline.studio.first_frames import FirstFrames
from pipeline.studio.newest import Newest, Superseded
from pipeline.studio.render_queue import Render, RenderQueue
from pipeline.studio.scene_play import forbidden_runs
from pipeline.studio.walk import figure_walk
from tests.studio.conftest import SCENE, Served

FIGURES = sorted((library() / "figures").glob("*.yaml"))


def opened(served: Served, name: str = "library:figures/beetle.yaml") -> Any:
    status, document = served.ask("open", name=name)
    assert status == 200
    return document


def test_a_drawing_is_analysed_as_the_command_does(served: Served) -> None:
    document = opened(served)
    status, answer = served.ask("analyse", text=document["text"], drawing=document["drawing"])
    assert status == 200
    kinds = [limb["kind"] for limb in answer["limbs"]]
    assert (kinds.count("leg"), kinds.count("head"), kinds.count("feeler")) == (6, 1, 2)
    assert answer["mass"] == pytest.approx(1389, rel=0.01)
    twin = next(node for node in answer["nodes"] if node["name"] == "foot1_r")
    assert (twin["source"], twin["is_drawn"], twin["at"]) == ("foot1_l", False, [1.17, -1.49])
    moving = served.ask(
        "analyse", text=document["text"], drawing=document["drawing"], is_moving=True
    )[1]
    assert (moving["mass"], moving["limbs"]) == (None, answer["limbs"])


@pytest.mark.sample(4)
@pytest.mark.parametrize("file", FIGURES, ids=lambda file: file.stem)
def test_a_drawing_that_did_not_change_makes_the_same_figure(file) -> None:
    config = figure_of_text(file.read_text(encoding="utf-8"))
    again = with_drawing(config, DrawnFigure.from_json(DrawnFigure.of(config).as_json()))
    one, two = (build_figure("it", figure, 1.0) for figure in (config, again))
    assert (one.drawing.places == two.drawing.places).all()
    assert one.drawing.materials == two.drawing.materials
    assert one.skeleton.joint_names == two.skeleton.joint_names


def test_warnings_stand_at_their_nodes(served: Served) -> None:
    document = opened(served)
    document["drawing"]["nodes"]["stray"] = {"at": [1.4, 1.4], "radius": 0.1}
    answer = served.ask("analyse", text=document["text"], drawing=document["drawing"])[1]
    assert any(w["node"].startswith("stray") for w in answer["warnings"])


def test_what_is_no_figure_is_told_with_its_path(served: Served) -> None:
    document = opened(served)
    document["drawing"]["chains"].append(["head", "nobody"])
    status, answer = served.ask("analyse", text=document["text"], drawing=document["drawing"])
    assert status == 422
    assert any("nobody" in problem["message"] for problem in answer["problems"])


def test_a_figure_is_saved_beside_the_scene_and_only_its_line_changes(served: Served) -> None:
    document = opened(served)
    document["drawing"]["nodes"]["foot1_l"]["at"] = [-1.2, -1.5]
    status, saved = served.ask(
        "save", name=document["name"], text=document["text"], drawing=document["drawing"]
    )
    assert (status, saved["name"]) == (200, "figures/beetle.yaml")
    before, after = document["text"], (served.folder / saved["name"]).read_bytes().decode()
    assert before != after
    lines = zip(before.splitlines(), after.splitlines(), strict=True)
    assert [a for a, b in lines if a != b] == [
        line for line in before.splitlines() if line.strip().startswith("foot1_l:")
    ]


def test_mistakes_of_a_figure_are_told_at_their_place(served: Served) -> None:
    text = opened(served)["text"]
    (served.folder / "figures").mkdir()
    (served.folder / "figures" / "bad.yaml").write_text(text.replace("style:", "sytle:"))
    bad = opened(served, "figures/bad.yaml")
    assert (bad["drawing"], [(p["line"], p["column"]) for p in bad["problems"]]) == (None, [(5, 3)])
    assert bad["error"].startswith("figures/bad.yaml:5:3: figure.sytle: unknown key")
    # Right as a text, but no limb has such a joint.
    joints = "  joints: {l9: {joint1_bend: {rest_deg: 1}}}\n  skin:"
    status, answer = served.ask("check", kind="figure", text=text.replace("  skin:", joints))
    assert (status, answer["drawing"]["settings"]["style"]) == (200, "insect")
    line = text[: text.index("  skin:")].count("\n") + 1
    assert [(p["line"], p["column"]) for p in answer["problems"]] == [(line, 17)]
    right = served.ask("check", kind="figure", text=text)[1]
    assert (right["error"], right["problems"]) == ("", [])


def test_a_new_figure_has_a_text_before_its_first_node(served: Served) -> None:
    document = served.ask("open")[1]
    assert (document["drawing"]["nodes"], document["error"]) == ({}, "")
    status, answer = served.ask("text", text=document["text"], drawing=document["drawing"])
    assert (status, answer["text"]) == (200, document["text"])
    document["drawing"]["nodes"] = {"a": {"at": [0, 0.5], "radius": 0.1}}
    answer = served.ask("text", text=document["text"], drawing=document["drawing"])[1]
    node = "nodes:\n    a: {at: [0, 0.5], radius: 0.1}\n  chains: []"
    assert answer["text"] == document["text"].replace("nodes:\n  chains:", node)


def test_why_a_figure_stands_is_told_without_a_scene() -> None:
    text = NEW_FIGURE.replace("nodes:", "nodes: {a: [0, 0], b: [0, 1], c: [1, 1]}")
    config = figure_of_text(text.replace("chains:", "chains: [[a, b, c]]"))
    facts = figure_walk(config, {}, lambda: None).facts
    assert facts["text"] == "stands: the figure has no legs to walk on"


@pytest.mark.slow
def test_a_figure_walks_with_its_gait(served: Served) -> None:
    document = opened(served)
    message = json.dumps({"text": document["text"], "drawing": document["drawing"]})
    status, glb = served.request("POST", "/api/walk", message.encode())
    assert (status, glb[:4]) == (200, b"glTF")


def test_mistakes_of_a_scene_are_told_at_their_place(served: Served) -> None:
    wrong = SCENE.replace("frames", "framse").replace("beetle", "beatle")
    status, answer = served.ask("check", kind="scene", text=wrong, name="walk.yaml")
    places = [(p["line"], p["column"]) for p in answer["problems"]]
    assert (status, places) == (422, [(2, 1), (5, 25)])
    assert "did you mean 'beetle'" in answer["problems"][1]["message"]
    assert served.ask("check", kind="scene", text=SCENE, name="walk.yaml")[0] == 200


def test_a_scene_is_simulated_with_events_and_gait(served: Served) -> None:
    status, facts = served.ask("take", text=SCENE, name="walk.yaml")
    assert status == 200
    assert (facts["frames"], facts["fps"], facts["performers"]) == (8, 24.0, ["bug"])
    assert len(facts["gait"][0]["legs"]) == 6
    body = json.dumps({"play": facts["play"]}).encode()
    assert served.request("POST", "/api/take.glb", body)[1][:4] == b"glTF"
    assert served.request("POST", "/api/still", body)[0] == 422
    newer = served.ask("take", text=SCENE.replace("frames: 8", "frames: 4"), name="walk.yaml")[1]
    assert newer["play"] > facts["play"]
    assert served.request("POST", "/api/take.glb", body)[0] == 409


@pytest.mark.slow
def test_a_scene_has_its_sound_and_its_camera(served: Served) -> None:
    facts = served.ask("take", text=SCENE, name="walk.yaml")[1]
    body = json.dumps({"play": facts["play"]}).encode()
    assert served.request("POST", "/api/sound", body)[1][:4] == b"RIFF"
    status, answer = served.ask("camera", play=facts["play"])
    assert (status, len(answer["camera"])) == (200, 8)


def test_a_scene_of_the_project_uses_figures_beside_it(served: Served) -> None:
    document = opened(served)
    (served.folder / "figures").mkdir()
    (served.folder / "figures" / "mine.yaml").write_text(document["text"])
    scene = SCENE.replace("beetle", "mine")
    assert served.ask("take", text=scene, name="walk.yaml")[0] == 200


def test_a_new_scene_is_a_right_one_and_is_not_written_twice(served: Served) -> None:
    status, document = served.ask("new-scene", name="hello")
    assert (status, document["name"], document["kind"]) == (200, "hello.yaml", "scene")
    assert served.ask("check", kind="scene", text=document["text"], name="hello.yaml")[0] == 200
    assert served.ask("new-scene", name="hello")[0] == 422
    assert served.ask("new-scene", name="../hello")[0] == 422


TINY = SCENE.replace("frames: 8", "frames: 2").replace("cells: [8, 8]", "scatter: none")


@pytest.mark.nightly
def test_a_film_is_rendered_by_the_queue(served: Served) -> None:
    (served.folder / "tiny.yaml").write_text(TINY + "film: {size: [64, 36], samples: 1}\n")
    (served.folder / "wrong.yaml").write_text(TINY.replace("frames", "framse"))
    numbers = [
        served.ask("render", name=name, preset="draft")[1]["number"]
        for name in ("tiny.yaml", "wrong.yaml")
    ]
    states: dict[int, Any] = {}
    end = time.monotonic() + 300
    while time.monotonic() < end and not set(states.values()) >= {"done", "failed"}:
        time.sleep(0.2)
        renders = served.ask("renders")[1]["renders"]
        states = {one["number"]: one["state"] for one in renders}
    assert [states[number] for number in numbers] == ["done", "failed"]
    assert "did you mean 'frames'" in renders[0]["text"]
    body = json.dumps({"number": numbers[0]}).encode()
    assert served.request("POST", "/api/rendered-frame", body)[1][:8] == b"\x89PNG\r\n\x1a\n"
    assert (served.folder / "out" / "tiny" / "tiny.mp4").stat().st_size > 0


@pytest.mark.nightly
@pytest.mark.slow
def test_a_film_is_stopped(served: Served) -> None:
    (served.folder / "long.yaml").write_text(TINY.replace("frames: 2", "frames: 2000"))
    first, second = (
        served.ask("render", name="long.yaml", preset="draft")[1]["number"] for _ in range(2)
    )
    assert served.ask("stop-render", number=second)[1]["state"] == "stopped"
    assert served.ask("stop-render", number=first)[1]["state"] == "stopped"
    served.studio.stop()
    states = {one["number"]: one["state"] for one in served.ask("renders")[1]["renders"]}
    assert states[first] == states[second] == "stopped"


def test_only_scenes_of_the_project_are_rendered_with_a_known_preset(served: Served) -> None:
    assert served.ask("render", name="walk.yaml", preset="best")[0] == 422
    assert served.ask("render", name="library:first_steps.yaml", preset="draft")[0] == 422
    assert served.ask("stop-render", number=12345)[0] == 422


def test_newer_work_stops_the_one_before_it() -> None:
    newest, started = Newest(), threading.Event()
    ended: list[str] = []

    def endless(still_wanted: Any) -> None:
        started.set()
        while True:
            still_wanted()
            time.sleep(0.001)

    def first() -> None:
        try:
            newest.run(endless)
        except Superseded:
            ended.append("superseded")

    thread = threading.Thread(target=first)
    thread.start()
    assert started.wait(10)
    assert newest.run(lambda still_wanted: "second") == "second"
    thread.join(10)
    assert ended == ["superseded"]


def test_files_of_others_are_not_replaced(served: Served) -> None:
    path = served.folder / "walk.yaml"
    path.write_text(SCENE)
    longer = SCENE.replace("frames: 8", "frames: 9")
    status, answer = served.ask("save", name="walk.yaml", text=longer, before=None)
    assert (status, "there is a file" in answer["error"]) == (422, True)
    assert served.ask("save", name="walk.yaml", text=longer, before=SCENE)[0] == 200
    status, answer = served.ask("save", name="walk.yaml", text=SCENE, before=SCENE)
    assert (status, "changed by another program" in answer["error"]) == (422, True)
    assert path.read_text() == longer


def test_modules_of_the_project_are_not_imported(served: Served) -> None:
    (served.folder / "json.py").write_text("open('imported', 'w').close()\n")
    (served.folder / "wrong.yaml").write_text(SCENE.replace("frames", "framse"))
    number = served.ask("render", name="wrong.yaml", preset="draft")[1]["number"]
    end = time.monotonic() + 60
    while time.monotonic() < end:
        (render,) = [x for x in served.ask("renders")[1]["renders"] if x["number"] == number]
        if render["state"] == "failed":
            break
        time.sleep(0.1)
    assert "did you mean 'frames'" in render["text"]
    assert not (served.folder / "imported").exists()


def test_channels_and_minds_of_a_performer_are_curves_and_strips(served: Served) -> None:
    text = SCENE.replace("frames: 8", "frames: 3") + (
        "  - {name: mother, character: adult, at: [2, 1]}\n"
        "  - {name: kid, character: child, at: [2, 2], traits: {},"
        " behaviours: [{attachment: mother}]}\n"
    )
    status, facts = served.ask("take", text=text, name="walk.yaml")
    assert status == 200, facts
    bug = served.ask("channels", play=facts["play"], who="bug")[1]
    phase = next(curve for curve in bug["curves"] if curve["name"] == "gait_phase")
    assert [time for time, _ in phase["points"]][:2] == pytest.approx([0.0, 1 / 96], abs=1e-4)
    assert phase["least"] == pytest.approx(min(value for _, value in phase["points"]), abs=1e-4)
    assert bug["strips"] == []
    kid = served.ask("channels", play=facts["play"], who="kid")[1]
    assert [strip["title"] for strip in kid["strips"]] == ["behaviour", "focus", "looks at"]
    assert {"anxiety", "distance"} <= {curve["name"] for curve in kid["curves"]}
    status, refused = served.ask("channels", play=facts["play"], who="nobody")
    assert (status, refused["error"]) == (422, "there is no performer 'nobody'")


def _shown_take(served: Served, page: str = "") -> Take:
    play = served.studio._pages[page].play
    assert play is not None
    return play[1].take


def test_pages_beside_each_other_keep_their_own_takes(served: Served) -> None:
    longer = SCENE.replace("frames: 8", "frames: 9")
    shown = {}
    for page, text in (("a", SCENE), ("b", longer)):
        status, facts = served.ask("take", text=text, page=page)
        assert status == 200
        shown[page] = facts["play"]
    # Not superseded by the other page's.
    assert served.ask("channels", play=shown["a"], who="bug", page="a")[0] == 200
    assert _shown_take(served, "a").header.frames == 8
    assert served.ask("channels", play=shown["a"], who="bug", page="b")[0] == 409
    for k in range(MAX_PAGES):
        assert served.ask("channels", play=0, who="bug", page=f"other {k}")[0] == 409
    # Those used longest ago are forgotten.
    assert len(served.studio._pages) == MAX_PAGES
    assert served.ask("channels", play=shown["a"], who="bug", page="a")[0] == 409
    assert served.ask("take", text=SCENE, page=3)[0] == 422


def test_a_change_of_the_camera_keeps_the_take(served: Served) -> None:
    status, first = served.ask("take", text=SCENE, name="walk.yaml")
    take = _shown_take(served)
    text = SCENE + "camera: {follow: bug, view: side}\n"
    status, second = served.ask("take", text=text, name="walk.yaml")
    assert status == 200
    assert second["play"] > first["play"]
    assert _shown_take(served) is take
    served.ask("take", text=SCENE.replace("frames: 8", "frames: 9"), name="walk.yaml")
    assert _shown_take(served) is not take


def test_first_frames_grow_and_are_the_beginning_of_the_take(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = read_scene(SCENE, "scene", library())
    monkeypatch.setattr(first_frames, "DELAY", 0.0)
    written: list[Take] = []
    monkeypatch.setattr(
        first_frames, "take_glb", lambda take, _: (written.append(take), b"glTF")[1]
    )
    first = FirstFrames(scene)
    shown = [0]

    def watch() -> None:
        with contextlib.suppress(Superseded):
            while True:
                shown.append(first.wait(shown[-1]).facts["frames"])

    watcher = threading.Thread(target=watch)
    watcher.start()

    def see(simulation: Simulation) -> None:
        # In step with the one who watches, so that nothing depends on their speed.
        before = len(written)
        while first._wanted is None and len(written) == before:
            time.sleep(0.001)
        first.see(simulation)

    whole = Simulation(scene).run(see)
    first.end()
    watcher.join(10)
    assert len(shown) > 3
    assert shown == sorted(set(shown))
    assert len(written) == len(shown) - 1
    for take in written:
        rows = take.header.frames * take.header.samples + 1
        assert len(take.positions) == rows
        assert take.positions.tobytes() == whole.positions[:rows].tobytes()
        assert take.rotations.tobytes() == whole.rotations[:rows].tobytes()
    # To look at what there is so far changes nothing of what follows.
    assert whole.positions.tobytes() == simulate(scene).positions.tobytes()
    with pytest.raises(Superseded):
        first.wait()


def test_first_frames_of_another_request_are_refused(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_frames, "PATIENCE", 0.01)
    assert served.ask("first-frames", request="unknown")[0] == 409


def test_cells_without_footholds_are_runs_on_the_map(served: Served) -> None:
    ditches = "{kind: ditches, size: [8, 8], cells: [40, 40], width: 1, spacing: 3}"
    text = SCENE.replace("{kind: flat, size: [8, 8], cells: [8, 8]}", ditches)
    scene = read_scene(text.replace("frames: 8", "frames: 1"), "scene", library())
    take = simulate(scene)
    found = forbidden_runs(take.terrain)
    assert found is not None
    assert (found["corner"], found["cell"]) == ([-4.0, -4.0], pytest.approx([0.2, 0.2]))
    cells = np.zeros_like(take.terrain.forbidden)
    for row, start, end in found["runs"]:
        cells[row, start:end] = True
    assert (cells == take.terrain.forbidden).all()
    assert forbidden_runs(simulate(read_scene(SCENE, "scene", library())).terrain) is None


def test_the_folder_of_a_film_is_opened(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    queue = RenderQueue(lambda: served.folder)
    render = Render(1, "walk.yaml", "draft")
    opened: list[str] = []
    codes = [0, 1]
    monkeypatch.setattr("typer.launch", lambda path: (opened.append(path), codes.pop(0))[1])
    with pytest.raises(UsageError, match="there is no folder"):
        queue.open_folder(render)
    folder = served.folder / "out" / "walk"
    folder.mkdir(parents=True)
    assert queue.open_folder(render) == folder
    assert opened == [str(folder)]
    with pytest.raises(UsageError, match="no file manager"):
        queue.open_folder(render)
