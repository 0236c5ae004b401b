"""The command line: help, results, and one clear message for every mistake."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from pipeline import cli
from pipeline.commands import options
from pipeline.production.run import interrupts
from pipeline.simulation.figures.figure import build_figure
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene

Pronk = Callable[..., tuple[int, str, str]]
FIGURES = Path(__file__).parents[1] / "scenes/figures"

SCENE = """\
pronk: 1
title: Tiny
frames: 8
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, scale: 0.6, walk: {gait: tripod, cycle: 0.3, speed: 0.6}}
light: studio
film: {size: [64, 36], samples: 1, depth: 2, denoise: "off"}
"""

# Commands that read a scene, with their further arguments.
COMMANDS = {
    "render": (),
    "check": (),
    "simulate": (),
    "midi": (),
    "frame": ("1",),
    "sheet": (),
}
MAKERS = [name for name in COMMANDS if name != "check"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder with a scene and outputs of an earlier run."""
    (tmp_path / "tiny.yaml").write_text(SCENE, encoding="utf-8")
    frames = tmp_path / "out" / "tiny" / "frames"
    frames.mkdir(parents=True)
    (frames / "0001.png").write_bytes(b"earlier")
    (frames.parent / "tiny.mp4").write_bytes(b"earlier")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def pronk(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Pronk:
    """Return a function that runs a command: exit code, standard output, standard error."""

    def run(*arguments: str) -> tuple[int, str, str]:
        capfd.readouterr()
        monkeypatch.setattr(sys, "argv", ["pronk", *arguments])
        monkeypatch.setattr(options.CURRENT, "options", options.Verbosity())
        # The test runner listens to Ctrl-C itself.
        monkeypatch.setattr(cli, "listen", lambda: None)
        with pytest.raises(SystemExit) as end:
            cli.main()
        captured = capfd.readouterr()
        return int(end.value.code or 0), captured.out, captured.err

    return run


@pytest.fixture
def refused(pronk: Pronk, folder: Path) -> Callable[..., str]:
    """Return a function that runs a failing command, which changes no file: its message."""

    def files() -> dict[str, bytes]:
        # Folders count as well, and files that only hold a lock.
        return {str(p): p.read_bytes() if p.is_file() else b"" for p in folder.rglob("*")}

    def run(code: int, *arguments: str) -> str:
        before = files()
        found, out, err = pronk(*arguments)
        assert found == code, err
        assert out == ""
        assert "Traceback" not in err
        assert files() == before
        return err

    return run


_MODULES = """
import sys
sys.argv = ["pronk", *sys.argv[1:]]
from pipeline.cli import main
try:
    main()
finally:
    sys.stderr.write(" ".join(sorted(sys.modules)))
"""


def test_help_imports_no_heavy_module() -> None:
    root = str(Path(cli.__file__).parents[1])
    arguments = [sys.executable, "-c", _MODULES, "--help"]
    env = {**os.environ, "PYTHONPATH": root}
    end = subprocess.run(arguments, capture_output=True, text=True, env=env, check=True)
    modules = set(end.stderr.split())
    assert "typer" in modules
    heavy = {"numpy", "pydantic", "mitsuba", "drjit", "zarr", "yaml", "av", "mido", "PIL"}
    assert modules & heavy == set()
    for command in (
        "render",
        "check",
        "figure",
        "schema",
        "simulate",
        "midi",
        "frame",
        "sheet",
        "new",
    ):
        assert f" {command} " in end.stdout


@pytest.mark.parametrize("command", [*COMMANDS, "schema", "new", "doctor"])
def test_every_command_has_help(pronk: Pronk, command: str) -> None:
    code, out, _ = pronk(command, "--help")
    assert code == 0
    assert f"pronk {command}" in out


@pytest.mark.parametrize("error", [ValueError("as text alone: KeyboardInterrupt"), KeyError()])
def test_errors_after_ctrl_c_end_as_an_interrupt(
    error: Exception, pronk: Pronk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def app(prog_name: str) -> None:
        raise error

    monkeypatch.setattr(cli, "app", app)
    monkeypatch.setattr(cli, "ignore", lambda: None)
    code, out, err = pronk("check")
    assert (code, out) == (4, "")
    assert err.startswith(f"error: a defect of pronk, please report it: {error!r}\n")
    monkeypatch.setattr(interrupts, "heard", lambda: True)
    code, out, err = pronk("check")
    assert (code, out) == (cli.INTERRUPTED, "")
    assert err.startswith("stopped; ")


def test_version_is_printed(pronk: Pronk) -> None:
    import pipeline

    assert pronk("--version") == (0, f"pronk {pipeline.__version__}\n", "")


@pytest.mark.parametrize("flag", [(), ("--figure",)])
def test_schemas_are_of_draft_07(pronk: Pronk, flag: tuple[str, ...]) -> None:
    code, out, _ = pronk("schema", *flag)
    schema = json.loads(out)
    assert code == 0
    assert schema["$schema"] == "http://json-schema.org/draft-07/schema#"
    jsonschema.Draft7Validator.check_schema(schema)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("midi", "tiny", "--preset", "draft"), "'--preset' is an option of render, frame, sheet"),
        (("check", "tiny", "--strikt"), "no option is called '--strikt', did you mean '--strict'?"),
        (("list", "--zzz"), "no option is called '--zzz'; list has --json"),
        (("new", "-z"), "no option is called '-z'; new has none"),
    ],
)
def test_an_unknown_option_is_led_to_the_meant_one(
    pronk: Pronk, folder: Path, arguments: tuple[str, ...], message: str
) -> None:
    code, _, err = pronk(*arguments)
    words = [word for word in err.split() if word != "│"]
    assert code == 2
    assert message in " ".join(words)


@pytest.mark.parametrize(
    "arguments",
    [
        ("re\x1b[31mnder",),
        ("--o\x1bdd",),
        ("check", "tiny", "--o\x1bdd"),
        ("render", "tiny", "--preset", "dr\x1b[2J\u202eaft"),
        ("golden", "re\x9bcord"),
        ("list", "a", "b\x1b\udcff"),
    ],
    ids=repr,
)
def test_usage_errors_print_no_control_characters(
    pronk: Pronk, folder: Path, arguments: tuple[str, ...]
) -> None:
    code, _, err = pronk(*arguments)
    assert code == 2
    assert not re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e\udcff]", err)
    assert re.search(r"\\x(1b|9b)", err)


@pytest.mark.parametrize("command", ["list", "check"])
def test_a_folder_of_goldens_that_no_system_allows_is_refused(
    refused: Callable[..., str], command: str
) -> None:
    name = "x" * 300
    told = refused(2, "golden", command, "--goldens", name)
    assert told == f"error: --goldens {name}: cannot be read: File name too long\n"


def test_check_summarises_valid_scenes(pronk: Pronk, folder: Path) -> None:
    code, out, err = pronk("check", "tiny", "tiny.yaml")
    assert (code, len(out.splitlines())) == (0, 2)
    assert [line.split()[0] for line in err.splitlines()] == [
        *("[1/2]", "[2/2]", "scene", "tiny", "tiny.yaml")
    ]
    assert [line.split()[-1] for line in err.splitlines()[3:]] == ["right", "right"]
    assert out.startswith("tiny: right: 8 frames at 24 a second, 64x36; bug (beetle, 1.74 m long,")


def test_quiet_check_prints_nothing(pronk: Pronk, folder: Path) -> None:
    assert pronk("check", "tiny", "-q") == (0, "", "")


def test_doctor_lists_findings(pronk: Pronk) -> None:
    code, out, _ = pronk("doctor", "--json")
    findings = [json.loads(line) for line in out.splitlines()]
    named = {finding["what"]: finding for finding in findings}
    assert code == 0
    assert named["backend"]["ok"]
    assert named["scenes"]["ok"]
    assert {"Python", "pronk", "mitsuba", "machine"} <= named.keys()


def _arguments(command: str, scene: str, *more: str) -> tuple[str, ...]:
    return (command, scene, *COMMANDS[command], *more)


@pytest.mark.parametrize("command", COMMANDS)
def test_an_unknown_scene_suggests_the_nearest_name(
    refused: Callable[..., str], command: str
) -> None:
    near = refused(2, *_arguments(command, "tinny"))
    assert near.startswith("error: no scene is called 'tinny'")
    assert "'tiny'" in near
    assert "first_steps" in refused(2, *_arguments(command, "firststeps"))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_misspelt_key_is_shown_at_its_position(
    refused: Callable[..., str], folder: Path, command: str
) -> None:
    wrong = SCENE.replace("speed:", "strde:")
    (folder / "wrong.yaml").write_text(wrong, encoding="utf-8")
    column = wrong.splitlines()[5].index("strde") + 1
    message = refused(3, *_arguments(command, "wrong.yaml"))
    assert f"wrong.yaml:6:{column}: cast[0].walk.strde: " in message
    assert "stride" in message
    assert message.splitlines()[2] == " " * (4 + column - 1) + "^"


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("word", "message_part"),
    [
        ("cast.bug.walk.strde=1", "stride"),
        ("camra.view=top", "camera"),
        ("speed", "path=value"),
        ("fps=fast", "fps"),
        ("cast.bgu.scale=2", "'bug'"),
        ("=", "path"),
    ],
)
def test_an_invalid_override_is_refused(
    refused: Callable[..., str], command: str, word: str, message_part: str
) -> None:
    message = refused(3, *_arguments(command, "tiny", "--set", word))
    assert f"--set {word}" in message
    assert message_part in message


@pytest.mark.parametrize(
    ("frames", "message_part"),
    [
        ("abc", "cannot be read"),
        ("1-", "cannot be read"),
        ("0-3", "the scene has frames 1-8, no 0"),
        ("1-9999", "the scene has frames 1-8, no 9"),
        ("1-99999999999", "cannot be read"),
        ("-2", "the scene has frames 1-8, no -2"),
        ("1-3x0.5", "frames are whole"),
        ("", "names no frame"),
    ],
)
def test_invalid_frame_ranges_are_refused(
    refused: Callable[..., str], frames: str, message_part: str
) -> None:
    message = refused(2, "render", "tiny", "--frames", frames)
    assert f"--frames '{frames}': " in message
    assert message_part in message


@pytest.mark.parametrize("number", ["0", "9", "-1"])
def test_a_frame_outside_the_scene_is_refused(refused: Callable[..., str], number: str) -> None:
    message = refused(2, "frame", "tiny", "--", number)
    assert message == f"error: frame {number}: the scene has frames 1-8\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ("render",),
        ("render", "tiny", "--preset", "best"),
        ("render", "tiny", "--jobs", "0"),
        ("render", "tiny", "--jobs", "two"),
        ("render", "tiny", "--backend", "opencl"),
        ("frame", "tiny"),
        ("frame", "tiny", "one"),
        ("sheet", "tiny", "--count", "0"),
        ("sheet", "tiny", "--preset", "best"),
        ("check", "tiny", "--frames", "1"),
        ("dance", "tiny"),
    ],
    ids=" ".join,
)
def test_invalid_commands_print_their_usage(
    refused: Callable[..., str], arguments: tuple[str, ...]
) -> None:
    assert "Usage: pronk" in refused(2, *arguments)


@pytest.mark.parametrize("command", MAKERS)
def test_an_out_folder_that_is_a_file_is_refused(
    refused: Callable[..., str], folder: Path, command: str
) -> None:
    (folder / "note.txt").write_text("mine", encoding="utf-8")
    message = refused(4, *_arguments(command, "tiny", "--out", "note.txt"))
    named = "" if command == "frame" else "tiny.yaml: "
    assert message == (
        f"error: {named}note.txt/tiny: cannot be written to (Not a directory); "
        "choose another place with --out\n"
    )


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
@pytest.mark.parametrize("command", MAKERS)
def test_an_unwritable_out_folder_is_refused(
    refused: Callable[..., str], folder: Path, command: str
) -> None:
    (folder / "locked").mkdir(mode=0o500)
    assert "cannot be written to" in refused(4, *_arguments(command, "tiny", "--out", "locked"))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_scene_without_foothold_is_refused(refused: Callable[..., str], command: str) -> None:
    arguments = ("terrain.kind=fractal", "terrain.height=40", "terrain.unsteppable_slope_deg=1")
    sets = [piece for word in arguments for piece in ("--set", word)]
    message = refused(3, *_arguments(command, "tiny", *sets))
    assert "error: tiny.yaml:6:5: cast[0].at: leg " in message
    assert "no foothold" in message


def test_scenes_of_equal_name_are_refused(refused: Callable[..., str], folder: Path) -> None:
    (folder / "other").mkdir()
    (folder / "other" / "tiny.yaml").write_text(SCENE, encoding="utf-8")
    message = refused(2, "render", "tiny", "other/tiny.yaml")
    assert message.startswith("error: two scenes are called 'tiny', and both would write to ")


def test_verbose_check_warns_of_disconnected_nodes(pronk: Pronk, folder: Path) -> None:
    worm = "figures: {bug: {nodes: {a: [0, 0], b: [0, 1], x: [5, 5]}, chains: [[a, b]]}}\n"
    text = SCENE.replace("beetle, scale: 0.6, walk: {gait: tripod, cycle: 0.3, speed: 0.6}", "bug")
    (folder / "worm.yaml").write_text(text + worm)
    assert pronk("check", "worm")[0] == 0
    code, _, err = pronk("check", "worm", "-v")
    assert code == 0
    place = "worm.yaml:9:47: figures.bug.nodes.x"
    assert f"{place}: 'x' is not connected to the rest and ignored" in err


@pytest.mark.slow
def test_figure_prints_and_draws_a_figure(pronk: Pronk, folder: Path) -> None:
    code, out, _ = pronk("figure", "tiny.yaml:bug", "--out", "seen")
    assert code == 0
    assert "l3          leg, 3 links, 5 joints" in out
    assert (folder / "seen" / "beetle.svg").is_file()
    assert (folder / "seen" / "beetle.png").is_file()
    code, out, err = pronk("figure", "beatle")
    assert (code, out) == (2, "")
    assert err == (
        "error: no figure or scene is called 'beatle', did you mean 'beetle'? "
        "`pronk list figures` has all 23\n"
    )


def test_json_errors_are_json_lines(pronk: Pronk, folder: Path) -> None:
    code, out, err = pronk("check", "tiny", "--json", "--set", "cast.bug.walk.strde=1")
    (line,) = out.splitlines()
    entry = json.loads(line)
    assert (code, err) == (3, "")
    assert (entry["event"], entry["exit_code"]) == ("error", 3)
    assert entry["problems"][0]["path"] == "cast[0].walk.strde"
    assert json.loads(pronk("check", "nowhere", "--json")[1])["exit_code"] == 2


def test_of_many_problems_people_see_the_first_and_programs_all(pronk: Pronk, folder: Path) -> None:
    wrong = "".join(f"x{i}: 1\n" for i in range(30))
    (folder / "wrong.yaml").write_text(SCENE + wrong, encoding="utf-8")
    first = SCENE.count("\n") + 1
    code, out, err = pronk("check", "wrong.yaml")
    assert (code, out) == (3, "")
    places = re.findall(r"wrong\.yaml:(\d+):1: x", err)
    assert [int(line) for line in places] == [*range(first, first + 20)]
    assert err.endswith("\nand 10 more problems\n")
    entry = json.loads(pronk("check", "wrong.yaml", "--json")[1])
    assert len(entry["problems"]) == 30


def test_a_starter_scene_is_valid_and_not_overwritten(pronk: Pronk, folder: Path) -> None:
    assert pronk("new", "hello")[0] == 0
    text = (folder / "hello.yaml").read_bytes()
    assert pronk("check", "hello")[0] == 0
    code, out, err = pronk("new", "hello.yaml")
    assert (code, out) == (2, "")
    assert err == "error: hello.yaml: is there already; choose another name\n"
    assert (folder / "hello.yaml").read_bytes() == text


@pytest.mark.parametrize("command", ["check", "simulate", "render", "midi"])
def test_an_untrusted_scene_names_no_file_outside_its_folder(
    refused: Callable[..., str], folder: Path, command: str
) -> None:
    (folder.parent / "ball.obj").write_text("v 0 0 0\n")
    text = SCENE.replace("light: studio", "").replace("cast:", "cast:\n  - NEW")
    (folder / "tiny.yaml").write_text(
        text.replace("NEW", "{body: {shape: mesh, file: ../ball.obj}}"), encoding="utf-8"
    )
    told = refused(3, command, "tiny.yaml", "--untrusted")
    assert "tiny.yaml:6:32: cast[0].body.file: '../ball.obj' leads out of the folder" in told


@pytest.mark.parametrize("command", ["check", "simulate", "render", "midi"])
def test_scenes_beyond_a_budget_are_refused_with_a_line(
    refused: Callable[..., str], folder: Path, command: str
) -> None:
    large = SCENE.replace("cells: [8, 8]", "cells: [4000, 4000]")
    (folder / "tiny.yaml").write_text(large, encoding="utf-8")
    told = refused(3, command, "tiny.yaml", "--max-memory", "1GiB")
    assert "tiny.yaml:4:37: terrain.cells: the scene takes about " in told
    assert "cells would fit" in told
    many = SCENE.replace("cast:", "cast:\n  - {many: {layout: heap, count: 5000, of: box}}")
    (folder / "tiny.yaml").write_text(many, encoding="utf-8")
    told = refused(3, command, "tiny.yaml", "--max-time", "2s")
    assert "tiny.yaml:6:6: cast[0].many: the scene takes about " in told
    told = refused(2, command, "tiny.yaml", "--max-time", "2 years")
    assert told.startswith("error: --max-time '2 years' is no duration; ")


def test_an_untrusted_scene_has_limits_without_being_given_any(
    refused: Callable[..., str], folder: Path
) -> None:
    large = ("--set", "terrain.cells=[4000,4000]")
    told = refused(3, "render", "tiny.yaml", "--untrusted", *large)
    assert "more than the limit (--max-memory 4 GiB); about " in told
    slow = ("--set", "film.size=[1920,1080]", "--set", "film.samples=4096")
    told = refused(3, "render", "tiny.yaml", "--untrusted", *slow)
    assert "more than the limit (--max-time 30 min); " in told


@pytest.mark.parametrize("command", ["simulate", "render", "midi"])
@pytest.mark.parametrize("link", ["out", "out/tiny", "out/tiny/take.zarr"])
def test_outputs_of_an_untrusted_scene_follow_no_link(
    refused: Callable[..., str], folder: Path, command: str, link: str
) -> None:
    elsewhere = folder.parent / f"{folder.name}_elsewhere"
    elsewhere.mkdir()
    place = folder / link
    if place.exists():
        place.rename(folder / "moved")
    place.symlink_to(elsewhere)
    told = refused(4, command, "tiny.yaml", "--untrusted")
    assert f"{place.relative_to(folder)}: is a link that leads elsewhere" in told.replace(
        f"{folder}/", ""
    )
    assert not [*elsewhere.iterdir()]


@pytest.mark.parametrize("link", ["out", "out/film", "out/film/clips"])
def test_an_untrusted_sequence_keeps_to_its_folder(
    refused: Callable[..., str], folder: Path, link: str
) -> None:
    (folder / "film.yaml").write_text("pronk: 1\nsequence: [tiny]\n", encoding="utf-8")
    elsewhere = folder.parent / f"{folder.name}_elsewhere"
    elsewhere.mkdir()
    place = folder / link
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.exists():
        place.rename(folder / "moved")
    place.symlink_to(elsewhere)
    assert "is a link that leads elsewhere" in refused(4, "render", "film.yaml", "--untrusted")
    assert not [*elsewhere.iterdir()]
    (folder / "film.yaml").write_text("pronk: 1\nsequence: [../other]\n", encoding="utf-8")
    told = refused(3, "check", "film.yaml", "--untrusted")
    assert "film.yaml:2:12: sequence[0].scene: '../other' leads out of the folder" in told


def test_an_untrusted_sequence_has_limits_without_being_given_any(
    refused: Callable[..., str], folder: Path
) -> None:
    (folder / "film.yaml").write_text("pronk: 1\nsequence: [tiny]\n", encoding="utf-8")
    slow = ("--set", "film.size=[1920,1080]", "--set", "film.samples=4096")
    told = refused(3, "render", "film.yaml", "--untrusted", *slow)
    assert "more than the limit (--max-time 30 min); " in told


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the pictures of figures, which take seconds."""
    monkeypatch.setattr("pipeline.production.reports.figure_sheet.figure_svg", lambda *_: "<svg/>")
    monkeypatch.setattr("pipeline.production.reports.plot_files.png_of", lambda _: b"")


def figure_json(pronk: Pronk, name: str, *arguments: str) -> dict[str, Any]:
    """Return the JSON report of `pronk figure`."""
    code, out, _ = pronk("figure", name, "--json", *arguments)
    assert code == 0
    (line,) = out.splitlines()
    captured = json.loads(line)
    assert captured["event"] == "result"
    return dict(captured["figure"])


@pytest.mark.usefixtures("folder", "no_pictures")
def test_figure_prints_mass_properties_of_all_links(pronk: Pronk) -> None:
    report = figure_json(pronk, "tiny.yaml:bug")
    assert "denavit" not in report
    links = {link["name"]: link for link in report["links"]}
    assert {"body", "l1.1", "r3.3", "head.2"} <= links.keys()
    assert report["rest"]["mass"] == pytest.approx(sum(link["mass"] for link in links.values()))
    for link in report["links"]:
        inertia = np.array(link["inertia"])
        assert (inertia == inertia.T).all()
        assert (np.linalg.eigvalsh(inertia) > 0).all()
        assert (link["joint"] is None) == (link["name"] == "body")
    # The printed report has the same values with fewer digits.
    out = " ".join(pronk("figure", "tiny.yaml:bug")[1].split())
    one, two, three = (links[f"l3.{n}"]["mass"] for n in (1, 2, 3))
    assert f"{one + two + three:.3g} kg ({one:.3g} + {two:.3g} + {three:.3g})" in out
    x, y, _ = report["rest"]["centre"]
    assert f"{report['rest']['mass']:.4g} kg, body {links['body']['mass']:.3g} kg" in out
    assert f"centre of mass at rest ({x:.3f}, {y:.3f}, 0.000) m" in out


def _turn(axis: int, angle: float) -> Array:
    """Return the frame (4, 4) turned about x (0) or z (2)."""
    F = np.eye(4)
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    F[i, i] = F[j, j] = np.cos(angle)
    F[i, j], F[j, i] = -np.sin(angle), np.sin(angle)
    return F


def _step(axis: int, way: float) -> Array:
    F = np.eye(4)
    F[axis, 3] = way
    return F


def joint_frames(rows: list[dict[str, Any]], q: Array) -> Array:
    """Return the frames (J, 4, 4) of joints from their Denavit-Hartenberg table."""
    moved: dict[str, Array] = {"body": np.eye(4)}
    left = list(zip(rows, q, strict=True))
    while left:
        row, value = left.pop(0)
        if row["parent"] not in moved:
            left.append((row, value))
            continue
        theta, alpha = np.radians([row["theta_deg"], row["alpha_deg"]])
        link = _turn(2, theta) @ _step(2, row["r"]) @ _step(0, row["a"]) @ _turn(0, alpha)
        value_of = _step if row["kind"] == "prismatic" else _turn
        moved[row["joint"]] = moved[row["parent"]] @ link @ value_of(2, value)
    return np.array([moved[row["joint"]] @ np.array(row["tool"]) for row in rows])


@pytest.mark.sample(6)
@pytest.mark.usefixtures("folder", "no_pictures")
@pytest.mark.parametrize("name", sorted(path.stem for path in FIGURES.glob("*.yaml")))
def test_printed_parameters_reproduce_poses(pronk: Pronk, name: str) -> None:
    rows = figure_json(pronk, name, "--dh")["denavit"]
    scene = read_scene(f"pronk: 1\nduration: 1\ncast: [{{figure: {name}}}]\n")
    skeleton = build_figure(name, scene.figures[name], 1.0).skeleton
    assert [row["joint"] for row in rows] == list(skeleton.joint_names)
    rng = np.random.default_rng(1)
    for q in (skeleton.preferred, *rng.uniform(skeleton.lower, skeleton.upper, (3, len(rows)))):
        assert np.abs(joint_frames(rows, q) - JointTree.of(skeleton).pose(q)).max() < 1e-9


@pytest.mark.usefixtures("folder", "no_pictures")
def test_figure_prints_a_table_of_parameters(pronk: Pronk) -> None:
    _, out, _ = pronk("figure", "robot_arm", "--dh")
    lines = out.splitlines()
    begin = next(i for i, line in enumerate(lines) if "Denavit-Hartenberg" in line)
    assert lines[begin + 1].split() == "joint after kind theta r a alpha".split()
    assert lines[begin + 2].strip() == "arm_m1"
    rows = [line.split() for line in lines[begin + 3 : begin + 10]]
    assert rows[0][:3] == ["base_yaw", "body", "revolute"]
    assert rows[5][:3] == ["joint3_bend", "joint2_bend", "prismatic"]
    assert [float(number) for number in rows[4][3:]] == [-90.0, 0.0, 0.64, 0.0]
    assert "-0.0000 " not in out
