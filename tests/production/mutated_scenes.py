"""Mutated scenes: shipped scenes with seeded damage to their bytes, their text or their values.

The damage is that of the file formats' tests, and what only a scene language has: words of the
library and of other scenes in wrong places, blocks of one scene in another, numbers at the ends of
their range, anchors and aliases, repeated keys, tabs and other encodings.
"""

from __future__ import annotations

import copy
import json
import random
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from pipeline.spec import schema
from pipeline.spec.scene_library import library
from pipeline.spec.yaml_reader import read_file
from pipeline.spec.yaml_tree import plain_values

Steps = tuple[str | int, ...]

EXTREMES: tuple[Any, ...] = (
    *(0, -1, 1, 2**31, 2**63 - 1, 2**63, -(2**63), 10**30, 10**400),
    *(0.0, -0.0, 1e-320, 5e-324, 1e-9, 1e-3, 0.5, 1e4, 1e9, 1e16, 1e150, 1e308, -1e308),
    *(float("nan"), float("inf"), float("-inf"), True, False, None),
    *("", " ", "~", "null", "on", "1_000", "1:30", "0x10", "1e999", "²", "١٢", "12", "3-4"),
    *("x" * 65, "x" * 300, "é" * 300, "\ud7ff", "a\nb", "a\tb", "\u202ea", "a.b", "a[0]", "*", "&"),
    *("../../etc/passwd", "/", ".", "./missing.yaml", "C:\\a", "scene.yaml", "%s{0}"),
    *([], {}, [[]], [None], {"": None}, [0, 0], [0, 0, 0], [1e308] * 3, [1e-320] * 2, {"a": {}}),
)
"""Values that any value is replaced by."""

FACTORS = (-1, 0.1, 10, 1e-3, 1e3, 1e-6, 1e6)
"""Numbers are multiplied by these."""

ODD_TOKENS = (
    *("~", "-1", "0", "1e9", ".nan", ".inf", "-.inf", "[]", "{}", "true", "'3'", "!x 1", "? a"),
    *("- b", "{a: [1, 2]}", "x: 1", "|\n  text", ">", "\t", "<<: *a", "&a", "*a", "&a [*a]"),
    *("9999999999999999999", "1e-320", "1e308", "!!binary aGk=", "!!python/object:os.system x"),
    *("#", "---", "...", "%YAML 1.1", "%TAG ! x", "@", "`", "\\", '"\\x', '"\\UFFFFFFFF"', "é"),
    *("\u2028", "\x85", "\x00", "\x1b", "\ufeff", "١", "[" * 60, "{a: " * 60, "- " * 60, "x" * 300),
    *(":", ": ", ",", "]", "}", "[", "{", "\n", "\n  ", "\n    - ", "'", '"'),
)
"""Text that tokens are replaced by."""

ENCODINGS = ("utf-16", "utf-16-le", "utf-32", "latin-1", "cp1252", "utf-8-sig", "utf-7")

MAX_COPIES = 40
"""Copies of a list's item."""

LARGE = ("macarena", "parade", "procession", "square")
"""Scenes that take seconds to build; they hold nothing that others do not."""

CELLS = 24
"""Cells of the grounds along each side, where nothing on them needs more."""

FEATURES = {"diameter", "diameters", "gap", "step_depth", "file"}
"""Keys of grounds whose features need cells as small as they are."""


@dataclass(frozen=True)
class Corpus:
    """What scenes are mutated and mixed from.

    Attributes:
        scenes: right scenes as values.
        words: names of the library, and other words of the language.
        keys: of all blocks.
        values: by key, what the scenes hold under it.
    """

    scenes: tuple[dict[str, Any], ...]
    words: tuple[str, ...]
    keys: tuple[str, ...]
    values: dict[str, list[Any]]

    @staticmethod
    @cache
    def shipped(*names: str) -> Corpus:
        """Return shipped scenes, with the figures and dances that they use written into them.

        Their grounds have few cells, so that thousands are built in minutes.

        Args:
            names: of the scenes, by default all but the large ones.
        """
        every = [file.stem for file in sorted(library().glob("*.yaml"))]
        names = names or tuple(name for name in every if name not in LARGE)
        scenes = tuple(_scene(library() / f"{name}.yaml") for name in names)
        language = schema()
        words, keys = sorted({*_words(language)}), sorted({*_keys(language)})
        values: dict[str, list[Any]] = {}
        for scene in scenes:
            for path in paths_in(scene):
                values.setdefault(str(path[-1]), []).append(at(scene, path))
        return Corpus(scenes, tuple(words), tuple(keys), values)


def _scene(file: Path) -> dict[str, Any]:
    scene = values_of(file)
    for block, key in (("figures", "figure"), ("dances", "dance")):
        for member in scene["cast"]:
            name = member.get(key)
            beside = library() / block / f"{name}.yaml"
            if isinstance(name, str) and beside.is_file() and name not in scene.get(block, {}):
                scene.setdefault(block, {})[name] = values_of(beside)[key]
    terrain = scene.get("terrain")
    if isinstance(terrain, dict) and terrain.get("preset") != "stairs" and "of" not in terrain:
        if not FEATURES & terrain.keys():
            terrain["cells"] = [CELLS, CELLS]
    return scene


def values_of(file: Path) -> dict[str, Any]:
    """Return what a right file holds."""
    tree, problems = read_file(file)
    assert tree is not None
    assert not problems
    values: dict[str, Any] = _with_lists(plain_values(tree))
    return values


def _with_lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_lists(below) for key, below in value.items()}
    return [_with_lists(below) for below in value] if isinstance(value, tuple) else value


def _keys(language: Any) -> Iterator[str]:
    """Yield the keys of all blocks of a schema."""
    if isinstance(language, dict):
        properties = language.get("properties")
        yield from properties if isinstance(properties, dict) else ()
    for inner in _inner(language):
        yield from _keys(inner)


def _words(language: Any) -> Iterator[str]:
    """Yield the words that a schema allows somewhere."""
    if isinstance(language, dict):
        listed = [*language.get("enum", []), language.get("const")]
        yield from (word for word in listed if isinstance(word, str))
    for inner in _inner(language):
        yield from _words(inner)


def _inner(value: Any) -> Sequence[Any]:
    if isinstance(value, dict):
        return [*value.values()]
    return value if isinstance(value, list) else []


def paths_in(value: Any, above: Steps = ()) -> Iterator[Steps]:
    """Yield the paths of all values within a value."""
    if isinstance(value, dict | list):
        for step, below in value.items() if isinstance(value, dict) else enumerate(value):
            yield (*above, step)
            yield from paths_in(below, (*above, step))


def at(scene: Any, path: Steps) -> Any:
    """Return the value at a path."""
    for step in path:
        scene = scene[step]
    return scene


def mutated_scene(corpus: Corpus, seed: int) -> bytes:
    """Return a scene with some mutations, the same for the same seed."""
    rng = random.Random(seed)
    scene = copy.deepcopy(rng.choice(corpus.scenes))
    level = rng.choices(("values", "text", "bytes"), (13, 5, 2))[0]
    for _ in range(rng.choice((1, 1, 1, 2, 3)) if level == "values" else rng.randrange(2)):
        rng.choice(_VALUE_MUTATIONS)(rng, scene, corpus)
    text = _dumped(rng, scene)
    if level == "values":
        return text.encode("utf-8", "surrogatepass")
    if level == "text":
        for _ in range(rng.choice((1, 1, 2, 4))):
            text = rng.choice(_TEXT_MUTATIONS)(rng, text, corpus) if text.strip() else text
        return text.encode("utf-8", "surrogatepass")
    content = bytearray(text.encode("utf-8", "surrogatepass"))
    for _ in range(rng.choice((1, 1, 2, 8))):
        rng.choice(_BYTE_MUTATIONS)(rng, content)
    return bytes(content)


def _dumped(rng: random.Random, scene: Any) -> str:
    style = rng.choice((None, None, False, True))
    if rng.random() < 0.1:
        # JSON is YAML, too.
        return json.dumps(scene, ensure_ascii=rng.random() < 0.5)
    return str(yaml.dump(scene, Dumper=_Dumper, default_flow_style=style, sort_keys=False))


class _Dumper(yaml.SafeDumper):
    """Writes aliases for values that stand in several places on purpose alone."""

    def ignore_aliases(self, data: Any) -> bool:
        """Return whether a value is written out each time."""
        return not isinstance(data, _Shared)


class _Shared(list[Any]):
    """A list that is written once, with an anchor."""


_Dumper.add_representer(_Shared, yaml.SafeDumper.represent_list)


# --- mutations of values ------------------------------------------------------------


def _some_path(rng: random.Random, scene: Any, wanted: Callable[[Any], bool]) -> Steps | None:
    """Return a path to a value of some kind, blocks as often as their members."""
    paths = [path for path in paths_in(scene) if wanted(at(scene, path))]
    if not paths:
        return None
    # Else most mutations would strike the nodes of figures, which are the most.
    tops = sorted({str(path[0]) for path in paths})
    weights = [4 if isinstance(scene.get(top), dict | list) else 1 for top in tops]
    top = rng.choices(tops, weights)[0]
    return rng.choice([path for path in paths if str(path[0]) == top])


def _put(scene: Any, path: Steps, value: Any) -> None:
    at(scene, path[:-1])[path[-1]] = value


def _any(value: Any) -> bool:
    return True


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_word(value: Any) -> bool:
    return isinstance(value, str)


def _is_block(value: Any) -> bool:
    return isinstance(value, dict)


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and bool(value)


def _set_extreme(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, rng.choice((_any, _is_number, _is_word)))
    if path:
        _put(scene, path, copy.deepcopy(rng.choice(EXTREMES)))


def _scale_number(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, _is_number)
    if path:
        value = at(scene, path)
        _put(scene, path, rng.choice((*(value * f for f in FACTORS), value + 1, value - 1, -value)))


def _swap_word(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, _is_word)
    if path:
        others = [value for p in paths_in(scene) if _is_word(value := at(scene, p))]
        _put(scene, path, rng.choice(corpus.words if rng.random() < 0.6 else others))


def _cross(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    """Put what another scene has under a key in place of what this one has there."""
    path = _some_path(rng, scene, _any)
    if path and str(path[-1]) in corpus.values:
        _put(scene, path, copy.deepcopy(rng.choice(corpus.values[str(path[-1])])))


def _cross_blocks(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    """Exchange whole blocks: terrain, figures, moods, script, cast, camera, light, sound."""
    other = rng.choice(corpus.scenes)
    for key in rng.sample(sorted(other), rng.randint(1, 3)):
        value = copy.deepcopy(other[key])
        held = scene.get(key)
        if isinstance(held, list) and isinstance(value, list) and rng.random() < 0.6:
            value = [*held, *value]
        elif isinstance(held, dict) and isinstance(value, dict) and rng.random() < 0.6:
            value = {**held, **value}
        scene[key] = value


def _add_key(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, _is_block)
    block = at(scene, path) if path and rng.random() < 0.8 else scene
    key = rng.choice(corpus.keys)
    known = corpus.values.get(key)
    block[key] = copy.deepcopy(rng.choice(known if known else EXTREMES))


def _remove(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, _any)
    if path:
        del at(scene, path[:-1])[path[-1]]


def _repeat_item(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, _is_list)
    if path:
        held = at(scene, path)
        where = rng.randrange(len(held))
        held[where:where] = [copy.deepcopy(held[where])] * rng.choice((1, 1, 3, MAX_COPIES))


def _rename_key(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, lambda value: isinstance(value, dict) and bool(value))
    block = at(scene, path) if path else scene
    if block:
        key = rng.choice(sorted(map(str, block)))
        where = rng.randrange(len(key) + 1)
        other = rng.choice((rng.choice(corpus.keys), key[:where] + key[where + 1 :], key.upper()))
        if key in block:
            block[other] = block.pop(key)


def _wrap(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    path = _some_path(rng, scene, _any)
    if path:
        value = at(scene, path)
        for _ in range(rng.choice((1, 1, 2, 60))):
            value = [value] if rng.random() < 0.5 else {rng.choice(corpus.keys): value}
        _put(scene, path, value)


def _swap(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    one, two = _some_path(rng, scene, _any), _some_path(rng, scene, _any)
    if one and two and not (_is_within(one, two) or _is_within(two, one)):
        first, second = at(scene, one), at(scene, two)
        _put(scene, one, second)
        _put(scene, two, first)


def _share(rng: random.Random, scene: Any, corpus: Corpus) -> None:
    """Let one list stand in several places, as an alias of the first."""
    path = _some_path(rng, scene, _is_list)
    if path:
        shared = _Shared(at(scene, path))
        places = [path]
        for _ in range(rng.randint(1, 3)):
            other = _some_path(rng, scene, _is_list)
            # A list within itself would have no end.
            if other and not any(_is_within(p, other) or _is_within(other, p) for p in places):
                places.append(other)
        for place in places:
            _put(scene, place, shared)


def _is_within(path: Steps, other: Steps) -> bool:
    return path[: len(other)] == other


_VALUE_MUTATIONS: tuple[Callable[[random.Random, Any, Corpus], None], ...] = (
    *(_set_extreme,) * 4,
    *(_scale_number,) * 4,
    *(_swap_word,) * 3,
    *(_cross,) * 3,
    *(_cross_blocks,) * 4,
    *(_add_key,) * 3,
    *(_remove, _repeat_item, _rename_key, _wrap, _swap, _share),
)


# --- mutations of text --------------------------------------------------------------


def _replace_token(rng: random.Random, text: str, corpus: Corpus) -> str:
    tokens = re.findall(r"\w+|\W", text)
    for _ in range(rng.choice((1, 1, 3))):
        where = rng.randrange(len(tokens))
        tokens[where] = rng.choice(
            (rng.choice(ODD_TOKENS), rng.choice(tokens), rng.choice(corpus.words))
        )
    return "".join(tokens)


def _replace_number(rng: random.Random, text: str, corpus: Corpus) -> str:
    places = [found.span() for found in re.finditer(r"-?\d+(\.\d+)?", text)]
    if not places:
        return text
    start, end = rng.choice(places)
    odd = ("1e-320", "1e308", "-1e308", ".nan", ".inf", "1e999", "9" * 500, "١٢", "0o17", "+.5")
    return text[:start] + rng.choice((*odd, "0", "-1", "12", "1.5.2", "1e5", "0.001")) + text[end:]


def _change_lines(rng: random.Random, text: str, corpus: Corpus) -> str:
    """Repeat, remove, move or indent a line otherwise."""
    lines = text.splitlines()
    where = rng.randrange(len(lines))
    line = lines[where]
    changes = (
        [line, line],
        [],
        [f" {line}"],
        [line.removeprefix(" ")],
        [f"\t{line}"],
        [line.replace("  ", "\t", 1)],
        [f"&anchor {line}"],
        [line, "  *anchor"],
        [line, "---"],
        [f"{line} # {line}"],
        [line.replace(": ", ":", 1)],
        [line.split(":")[0] + ": &a [*a]"],
    )
    lines[where : where + 1] = rng.choice(changes)
    return rng.choice(("\n", "\n", "\n", "\r\n", "\r", "\x85")).join(lines) + "\n"


def _repeat_key(rng: random.Random, text: str, corpus: Corpus) -> str:
    keys = list(re.finditer(r"(\w+): ", text))
    if not keys:
        return text
    key = rng.choice(keys)
    return f"{text[: key.start()]}{key[0]}{rng.choice(ODD_TOKENS)}, {text[key.start() :]}"


def _truncate(rng: random.Random, text: str, corpus: Corpus) -> str:
    return text[: rng.randrange(len(text) + 1)]


_TEXT_MUTATIONS: tuple[Callable[[random.Random, str, Corpus], str], ...] = (
    *(_replace_token,) * 3,
    *(_replace_number,) * 3,
    *(_change_lines,) * 3,
    _repeat_key,
    _truncate,
)


# --- mutations of bytes -------------------------------------------------------------


def _flip_bits(rng: random.Random, content: bytearray) -> None:
    for _ in range(rng.choice((1, 1, 3, 16)) if content else 0):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)


def _insert_bytes(rng: random.Random, content: bytearray) -> None:
    where = rng.randrange(len(content) + 1)
    odd = (b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc3", b"\xed\xa0\x80", b"\xf4\x90\x80\x80")
    content[where:where] = rng.choice((*odd, rng.randbytes(4), b"\t", b"\r", b"\x0c", b"\x1b[31m"))


def _remove_bytes(rng: random.Random, content: bytearray) -> None:
    where = rng.randrange(len(content) + 1)
    del content[where : where + rng.choice((1, 2, 8, 100))]


def _splice(rng: random.Random, content: bytearray) -> None:
    start, where = rng.randrange(len(content) + 1), rng.randrange(len(content) + 1)
    content[where:where] = content[start : start + rng.choice((1, 8, 100))]


def _encode(rng: random.Random, content: bytearray) -> None:
    text = content.decode("utf-8", "replace")
    content[:] = text.encode(rng.choice(ENCODINGS), "replace")


def _mark(rng: random.Random, content: bytearray) -> None:
    """Set one byte order mark or two in front."""
    content[:0] = rng.choice((b"\xef\xbb\xbf", b"\xef\xbb\xbf" * 2, b"\xff\xfe", b"\xfe\xff"))


_BYTE_MUTATIONS: tuple[Callable[[random.Random, bytearray], None], ...] = (
    *(_flip_bits,) * 3,
    *(_insert_bytes, _remove_bytes, _splice, _encode, _mark),
)
