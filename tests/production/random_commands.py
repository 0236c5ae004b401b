"""Random command lines: commands and options of `pronk` with right and wrong values.

Commands, options and the types of their values are those of the program, so that new ones are drawn
without a change here.
"""

from __future__ import annotations

import enum
import inspect
import random
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, get_args

import typer

from pipeline import cli
from pipeline.spec.name_catalogue import NAME_KINDS

SCENES = {
    "tiny.yaml": """\
pronk: 1
frames: 2
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, scale: 0.6, walk: {gait: tripod, cycle: 0.3, speed: 0.6}}
light: studio
film: {size: [32, 18], samples: 1, depth: 2, denoise: "off"}
""",
    "roo.yaml": """\
pronk: 1
frames: 3
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast: [{name: roo, figure: kangaroo, pronk: {}}]
script: [{at: 5, who: roo, do: stop}]
film: {size: [16, 16], samples: 1, depth: 2, denoise: "off"}
""",
    "wrong.yaml": "pronk: 1\nframes: two\ncast: [{figure: beatle}]\n",
    "bad.yaml": "pronk: {1\n",
    "empty.yaml": "",
    "latin.yaml": "pronk: 1\ntitle: \udce9\n",
    "od\udcffd.yaml": "pronk: 1\nframes: 1\ncast: [{figure: beetle}]\n",
    "e\x1b[31mscape.yaml": "pronk: 1\nframes: 1\ncast: [{figure: beetle}]\n",
    "stick.yaml": "pronk: 1\nfigure: {nodes: {a: [0, 0], b: [0, 1]}, chains: [[a, b]]}\n",
    "file": "not a folder\n",
}
"""Files in the working folder; surrogates stand for bytes."""

SCENE_WORDS = (
    *("tiny", "tiny", "tiny.yaml", "./tiny.yaml", "roo", "roo.yaml", "wrong", "bad.yaml", "empty"),
    *("latin.yaml", "od\udcffd.yaml", "e\x1b[31mscape", "stick", "stick.yaml", "file", "folder"),
    *("folder.yaml", "missing", "tinny", "tiny:bug", "tiny:ant", "roo.yaml:kangaroo", "out/tiny"),
    *("beetle", "out", ".", "..", "/dev/null", "tiny.yaml/", "a\nb", "\x1b]0;x\x07", "\udc80"),
)
PATHS = (
    *("out", "out", "other", "folder", "file", "file/below", "tiny.yaml", "/dev/null/x", "../up"),
    *("x" * 300, "deep/er/folder", "o\x1b[31mdd", "\udcff\udcfe", " ", "out/tiny/take.zarr", "a b"),
)
NUMBERS = (
    *("0", "1", "2", "3", "-1", "99", "256", "257", "65536", "65537", "70000", "1000000", "1.5"),
    *("9" * 30, "1e3", "nan", "inf", "١", "0x10", "one", "1_0", "-0", "+1", "1\x1b[2J"),
)
WORDS = (
    *("", " ", "-", "--", "~", "*", "x" * 300, "a\nb", "\x1b[31m", "\u202ea", "\udcff", "é"),
    *("%s{0}", "true", "None", "[]", "{}", "null", "0", "-1", "../x", "name", "two words", "a.b"),
)
ASSIGNMENTS = (
    *("frames=1", "fps=30", "seed=5", "film.size=[16,16]", "cast.bug.scale=0.5", "title=A"),
    *("=", "frames", "frames=", "frames=1e308", "cast.bgu.scale=2", "film.size=[320", "a.b"),
    *("cast[9].at=[0,0]", "film.samples=0", "light=nowhere", "script=[]", "fps=.nan", "pronk=2"),
    *("title=\x1b[31m", "seed=\udcff", "cast[0].walk.speed=1e-320", "duration=1"),
    "terrain.cells=[100000,100000]",
)
FRAMES = (
    *("1", "1-2", "2-1", "1-9", "0", "-1", "1-2x0.5", "abc", "", "1,2", "1-999999999999", "1-2x9"),
)
SIZES = (
    *("32x18", "16x16", "2x2", "0x0", "-1x5", "15x15", "x", "99999x99999", "16 x 16", "16×16"),
)
LAYERS = ("motion", "frames,film", "x", "")
SETS = {"frames": FRAMES, "size": SIZES, "sets": ASSIGNMENTS, "layers": LAYERS}
"""Values by the names of parameters, for a part of the draws."""

COSTLY = 0.25
"""Share of the draws of commands that render or wait which are kept."""

CHEAP = {"check", "schema", "new", "simulate", "midi", "list", "jumps", "verify", "effort", "cuts"}
"""Commands that end at once."""


@cache
def commands() -> dict[tuple[str, ...], Any]:
    """Return all commands by their names, those of groups behind the group's."""
    return dict(_commands(typer.main.get_command(cli.app)))


def _commands(group: Any, above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, command in group.commands.items():
        if getattr(command, "commands", None):
            yield from _commands(command, (*above, name))
        else:
            yield (*above, name), command


@cache
def option_uses() -> list[tuple[tuple[str, ...], Any]]:
    """Return every command with each of its options in turn, or with None."""
    return [
        (words, param)
        for words, command in sorted(commands().items())
        for param in [None, *(p for p in command.params if p.param_type_name == "option")]
    ]


def random_command(seed: int) -> list[str]:
    """Return the arguments of a random command line, the same for the same seed.

    The first seeds use every option of every command once.
    """
    rng = random.Random(seed)
    names = sorted(commands())
    words = rng.choice(names)
    while words[-1] not in CHEAP and rng.random() > COSTLY:
        words = rng.choice(names)
    wanted = None
    if seed < len(option_uses()):
        words, wanted = option_uses()[seed]
    elif rng.random() < 0.04:
        return [rng.choice((*WORDS, *(word for name in names for word in name))) for _ in range(2)]
    command = commands()[words]
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    options = [p for p in command.params if p.param_type_name == "option"]
    line = [word for param in arguments for word in _argument(rng, command, param)]
    chosen = rng.sample(options, min(rng.choice((0, 0, 1, 1, 2, 4)), len(options)))
    if wanted is not None and wanted not in chosen:
        chosen.append(wanted)
    for param in chosen:
        line[0 if rng.random() < 0.3 else len(line) :] = _option(rng, command, param)
    if rng.random() < 0.08:
        other = commands()[rng.choice(names)]
        found = [p for p in other.params if p.param_type_name == "option"]
        line += _option(rng, other, rng.choice(found)) if found else []
    if rng.random() < 0.05:
        line.insert(rng.randrange(len(line) + 1), rng.choice((*WORDS, "--strikt", "-z", "--help")))
    return [*words, *line]


def _argument(rng: random.Random, command: Any, param: Any) -> list[str]:
    """Return the words of an argument: mostly as many as it takes."""
    most = 3 if param.nargs != 1 and rng.random() < 0.3 else 1
    if rng.random() < 0.04:
        return []
    return [_value(rng, command, param) for _ in range(rng.randint(1, most))]


def _option(rng: random.Random, command: Any, param: Any) -> list[str]:
    name = rng.choice([*param.opts, *param.secondary_opts])
    if param.is_flag:
        return [name] if rng.random() < 0.95 else [f"{name}={rng.choice(WORDS)}"]
    value = _value(rng, command, param)
    if rng.random() < 0.03:
        return [name]
    return [f"{name}={value}"] if name.startswith("--") and rng.random() < 0.3 else [name, value]


def _value(rng: random.Random, command: Any, param: Any) -> str:
    """Return a value of a parameter: of its type, of another, or none at all."""
    if rng.random() < 0.08:
        return rng.choice((*WORDS, *NUMBERS, *SCENE_WORDS))
    if param.name in SETS:
        return rng.choice(SETS[param.name])
    kinds = _types(command, param.name)
    for kind in kinds:
        if isinstance(kind, type) and issubclass(kind, enum.Enum):
            return str(rng.choice([*kind]).value)
    if int in kinds:
        return rng.choice(("1", "2", "2", *NUMBERS))
    if Path in kinds:
        return rng.choice(PATHS)
    if param.name == "kind":
        return rng.choice((*NAME_KINDS, "figure", "zebra"))
    if param.name in ("name", "host"):
        return rng.choice(("new_one", "127.0.0.1", "::1", "localhost", *WORDS))
    return rng.choice(SCENE_WORDS)


def _types(command: Any, name: str) -> set[Any]:
    """Return the types in the annotation of a command's parameter."""
    parameters = inspect.signature(command.callback, eval_str=True).parameters
    pending, found = [parameters[name].annotation] if name in parameters else [], set()
    while pending:
        one = pending.pop()
        found.add(one if isinstance(one, type) else None)
        pending += [inner for inner in get_args(one) if inner is not None]
    return found


def lay_out(folder: Path) -> None:
    """Write the files that command lines name into a folder."""
    for name, content in SCENES.items():
        (folder / name).write_bytes(content.encode("utf-8", "surrogateescape"))
    (folder / "folder").mkdir()
    (folder / "folder.yaml").mkdir()
