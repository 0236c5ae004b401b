"""Name catalogue: the names that authors may write, by kind, with a short description of each.

All of it is read from registries, models, and the files of the library and of the author.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from pydantic.fields import FieldInfo

from audio.acoustic_materials import family_name
from audio.ambience import AMBIENCES
from audio.config.sound import Room, RoomName
from audio.general_midi import DRUMS, FAMILIES, FAMILY_SIZE, INSTRUMENTS, LOWEST_DRUM_KEY
from audio.harmony import MODES
from audio.room_acoustics import room_acoustics
from pipeline.errors import UsageError
from pipeline.spec import behaviour, body, group, prop
from pipeline.spec.character_kinds import KIND_TEXTS
from pipeline.spec.costume import COSTUME_TEXTS
from pipeline.spec.events import EVENTS
from pipeline.spec.library_search import DANCE_BLOCK, FIGURE_BLOCK, LibraryBlock
from pipeline.spec.model_base import ConfigModel
from pipeline.spec.mood import MOODS
from pipeline.spec.relations import RELATIONS
from pipeline.spec.scene_library import (
    SEQUENCES,
    SUFFIX,
    files_beside,
    library,
    names_in,
    scenes_in,
)
from pipeline.spec.scene_sequence import is_sequence
from pipeline.spec.script import flow_text, order_keys
from pipeline.spec.sound_thresholds import Detect
from pipeline.spec.suggestions import hint
from pipeline.spec.terrain.base import TERRAIN_KINDS, TERRAIN_PRESETS
from pipeline.spec.terrain.scatter import NAMES, SCATTER_PRESETS, SPECIES
from pipeline.spec.verbs import PERFORMERS, VERBS
from pipeline.spec.walk import LEG_REQUIREMENTS, GaitName
from render.config import LIGHTS, MATERIALS, Clouds, Film, Light, Look, Water, Weather
from render.config.base import PresetModel
from render.config.film import Preset
from render.config.light import HAZES
from render.config.titles import Title
from render.config.water import WAVES

OWN_GROUP = "this folder"
LIBRARY_GROUP = "library"

HEAD_BYTES = 4096
"""Of a file for its description: comments and title stand at the top."""

EDITOR_COMMENT = "yaml-language-server:"
"""Begins a comment for editors, which names the schema."""

SHOWN_OF_MATERIAL = ("metallic", "clearcoat", "sheen", "transmission", "glow")


@dataclass(frozen=True, slots=True)
class NameEntry:
    """A name that authors may write.

    Attributes:
        name: as it is written.
        text: short description.
        group: of similar names, empty where the kind has no groups.
    """

    name: str
    text: str
    group: str = ""


@dataclass(frozen=True, slots=True)
class NameKind:
    """A kind of names.

    Attributes:
        text: where they are written.
        entries: returns all of them, given the author's folder.
    """

    text: str
    entries: Callable[[Path], Iterable[NameEntry]]


def names_of(kind: str, folder: Path) -> list[NameEntry]:
    """Return the names of a kind, those of a group together.

    Args:
        kind: a key of `NAME_KINDS`.
        folder: of the author, whose own figures, dances and scenes are listed too.

    Raises:
        UsageError: there is no such kind.
    """
    if kind not in NAME_KINDS:
        raise UsageError(f"nothing is listed as '{kind}', {hint(kind, NAME_KINDS)}")
    entries = list(NAME_KINDS[kind].entries(folder))
    groups = list(dict.fromkeys(entry.group for entry in entries))
    return sorted(entries, key=lambda entry: groups.index(entry.group))


def _figures(folder: Path) -> Iterator[NameEntry]:
    return _entries(folder, FIGURE_BLOCK)


def _dances(folder: Path) -> Iterator[NameEntry]:
    return _entries(folder, DANCE_BLOCK)


def _scenes(folder: Path) -> Iterator[NameEntry]:
    shipped = {name: library() / (name + SUFFIX) for name in names_in(library())}
    return _files({} if folder.resolve() == library() else scenes_in(folder), shipped)


def _ambiences(folder: Path) -> Iterator[NameEntry]:
    yield NameEntry("auto", "by ground, hour and weather")
    yield NameEntry("none", "silence between the events")
    for name, ambience in AMBIENCES.items():
        layers = (f"{layer} {amount:g}" for layer, amount in ambience.layers.items())
        yield NameEntry(name, ", ".join(layers))


def _sequences(folder: Path) -> Iterator[NameEntry]:
    shelf = library() / SEQUENCES
    shipped = {name: shelf / (name + SUFFIX) for name in names_in(shelf)}
    own = {name: folder / (name + SUFFIX) for name in names_in(folder)}
    return _files({name: path for name, path in own.items() if is_sequence(path)}, shipped)


def _entries(folder: Path, block: LibraryBlock) -> Iterator[NameEntry]:
    shelf = library() / block.block
    shipped = {name: shelf / (name + SUFFIX) for name in names_in(shelf)}
    return _files(files_beside(folder, block.block, block.key), shipped)


def _files(own: Mapping[str, Path], shipped: Mapping[str, Path]) -> Iterator[NameEntry]:
    """Yield the author's own files, and those of the library that they do not replace."""
    known = {path.resolve() for path in shipped.values()}
    for name, path in own.items():
        if path.resolve() not in known:
            yield NameEntry(name, _description(path), OWN_GROUP)
    for name, path in shipped.items():
        if name not in own or own[name].resolve() in known:
            yield NameEntry(name, _description(path), LIBRARY_GROUP)


def _description(path: Path) -> str:
    """Return the first sentence of the comment at the top of a file, or else its title."""
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD_BYTES).decode("utf-8", "replace")
    except OSError:
        return ""
    comment = re.match(r"(?:\s*#.*\n?)+", head.removeprefix("\ufeff"))
    lines = comment[0].splitlines() if comment is not None else []
    paragraphs = "\n".join(line.lstrip("# ").rstrip() for line in lines).split("\n\n")
    for paragraph in paragraphs:
        text = " ".join(paragraph.split())
        if text and not text.startswith(EDITOR_COMMENT):
            return re.split(r"(?<=[.!?]) ", text)[0]
    title = re.search(r"^title:\s*(.+?)\s*$", head, re.MULTILINE)
    return title[1].strip("'\"") if title else ""


def _materials(_: Path) -> Iterator[NameEntry]:
    for name, material in MATERIALS.items():
        color = "#" + "".join(f"{round(255 * share):02x}" for share in material.color)
        texture = [] if material.texture == "none" else [f"texture {material.texture}"]
        shown = [
            f"{key} {getattr(material, key):g}"
            for key in SHOWN_OF_MATERIAL
            if getattr(material, key)
        ]
        yield NameEntry(
            name, ", ".join([color, *texture, *shown]), f"sounds like {family_name(name)}"
        )


def _terrains(_: Path) -> Iterator[NameEntry]:
    for name, preset in TERRAIN_PRESETS.items():
        kind = preset["kind"]
        changes = _values({key: value for key, value in preset.items() if key != "kind"})
        text = f"{kind} with {changes}" if changes else _sentence(TERRAIN_KINDS[kind])
        yield NameEntry(name, text, "by name")
    for kind, model in TERRAIN_KINDS.items():
        if kind not in TERRAIN_PRESETS:
            yield NameEntry(kind, _sentence(model), "as {kind: ..., and more keys}")


def _lights(_: Path) -> Iterator[NameEntry]:
    return (NameEntry(name, _values(Light.presets[name])) for name in LIGHTS)


def _preset_models(model: type[PresetModel]) -> Callable[[Path], Iterator[NameEntry]]:
    """Return the lister of a model's presets with their values."""

    def entries(_: Path) -> Iterator[NameEntry]:
        for name, values in model.presets.items():
            yield NameEntry(name, _values(values) or "the defaults")

    return entries


def _costumes(_: Path) -> Iterator[NameEntry]:
    for name, text in COSTUME_TEXTS.items():
        yield NameEntry(name, text)


def _strengths(words: Mapping[str, float]) -> Callable[[Path], Iterator[NameEntry]]:
    """Return the lister of words that stand for a number from 0 to 1."""
    return lambda _: (NameEntry(name, f"{value:g}") for name, value in words.items())


def _scatter(_: Path) -> Iterator[NameEntry]:
    for name in NAMES:
        species = SCATTER_PRESETS.get(name, {})
        text = ", ".join(species) or ("what suits the ground" if name == "auto" else "nothing")
        yield NameEntry(name, text)


def _species(_: Path) -> Iterator[NameEntry]:
    for name in SPECIES:
        users = [preset for preset, values in SCATTER_PRESETS.items() if name in values]
        yield NameEntry(name, f"in {', '.join(users)}" if users else "in no preset")


def _presets(_: Path) -> Iterator[NameEntry]:
    for name in get_args(Preset):
        film = Film(preset=name).resolved()
        width, height = film.size
        text = f"{width} x {height}, {film.samples} rays per pixel, {film.codec}"
        yield NameEntry(name, text)


def _gaits(_: Path) -> Iterator[NameEntry]:
    for name in get_args(GaitName):
        legs = LEG_REQUIREMENTS.get(name)
        yield NameEntry(name, f"Needs {legs}." if legs else "For any legs.")


def _moods(_: Path) -> Iterator[NameEntry]:
    return (NameEntry(name, _values(mood)) for name, mood in MOODS.items())


def _verbs(_: Path) -> Iterator[NameEntry]:
    for name, verb in VERBS.items():
        who = ", ".join(PERFORMERS[performer] for performer in verb.performers)
        keys = order_keys(name)
        texts = [f"{key}{_default(field)}" for key, field in keys.items()]
        yield NameEntry(name, verb.meaning + (f"; keys: {', '.join(texts)}" if keys else ""), who)


def _events(_: Path) -> Iterator[NameEntry]:
    for name, kind in EVENTS.items():
        of_many = f"; of `many` bodies {kind.of_many}" if kind.of_many else ""
        yield NameEntry(name, f"`{{{kind.example}}}`: {kind.meaning}{of_many}")


def _characters(_: Path) -> Iterator[NameEntry]:
    return (NameEntry(name, text) for name, text in KIND_TEXTS.items())


def _bodies(_: Path) -> Iterator[NameEntry]:
    yield from _variants(body.BodyShape, "shape", "body: {shape: ...}", body.Matter)
    yield from _variants(
        body.Layout, "layout", "many: {layout: ..., of: a shape}", body.Arrangement
    )


def _props(_: Path) -> Iterator[NameEntry]:
    return _variants(prop.Shape, "shape")


def _groups(_: Path) -> Iterator[NameEntry]:
    return _variants(group.GroupRule, "rule")


def _variants(
    union: object, tag: str, group: str = "", base: type[ConfigModel] = ConfigModel
) -> Iterator[NameEntry]:
    """Yield the names that tell the models of a union apart, each with its keys and defaults.

    Args:
        union: of models, annotated.
        tag: the key that tells them apart.
        group: of the names.
        base: of the models, whose keys are those of all.
    """
    for model in get_args(get_args(union)[0]):
        own = {
            key: field
            for key, field in model.model_fields.items()
            if key != tag and key not in base.model_fields
        }
        keys = ", ".join(f"{key}{_default(field)}" for key, field in own.items())
        for name in get_args(model.model_fields[tag].annotation):
            yield NameEntry(name, f"{_sentence(model)} Keys: {keys}.", group)


def _default(field: FieldInfo) -> str:
    """Return the default of a key after a blank, empty where it has none or an empty one."""
    is_empty = field.is_required() or field.default in (None, ())
    return "" if is_empty else f" {flow_text(field.default)}"


def _behaviours(_: Path) -> Iterator[NameEntry]:
    for name in behaviour.NAMES:
        form = behaviour.FORMS.get(name)
        yield NameEntry(name, _sentence(form) if form else behaviour.WITHDRAWAL_TEXT)


def _relations(_: Path) -> Iterator[NameEntry]:
    return (NameEntry(name, _sentence(model)) for name, model in RELATIONS.items())


def _instruments(_: Path) -> Iterator[NameEntry]:
    for program, name in enumerate(INSTRUMENTS):
        yield NameEntry(name, f"program {program + 1}", FAMILIES[program // FAMILY_SIZE])


def _drums(_: Path) -> Iterator[NameEntry]:
    return (NameEntry(name, f"key {key}") for key, name in enumerate(DRUMS, LOWEST_DRUM_KEY))


def _scales(_: Path) -> Iterator[NameEntry]:
    for name, steps in MODES.items():
        yield NameEntry(name, f"{' '.join(map(str, steps))} semitones above the root")


def _causes(_: Path) -> Iterator[NameEntry]:
    for name, field in Detect.model_fields.items():
        assert isinstance(field.annotation, type)
        yield NameEntry(name, _sentence(field.annotation))


def _rooms(_: Path) -> Iterator[NameEntry]:
    for name in get_args(RoomName):
        room = room_acoustics(Room(preset=name))
        size = " x ".join(f"{length:g}" for length in room.size) + " m" if room.size else "outdoors"
        yield NameEntry(name, f"{size}, reverberates for {room.seconds:g} s")


def _sentence(model: type) -> str:
    """Return the first line of the docstring of a model."""
    return (model.__doc__ or "").strip().split("\n")[0]


def _values(block: Mapping[str, object]) -> str:
    return ", ".join(f"{key} {flow_text(value)}" for key, value in block.items())


NAME_KINDS: Mapping[str, NameKind] = {
    "figures": NameKind("`figure:` of the cast, with their sizes at `scale: 1`", _figures),
    "dances": NameKind("`dance:` of dancers and of their orders", _dances),
    "scenes": NameKind("what commands take", _scenes),
    "ambiences": NameKind("`sound: {ambience: ...}`", _ambiences),
    "sequences": NameKind("several scenes as one film, for `pronk render`", _sequences),
    "materials": NameKind("`material:`, by what they sound like", _materials),
    "terrains": NameKind("`terrain:`", _terrains),
    "lights": NameKind("`light:`", _lights),
    "weather": NameKind("`light.weather`", _preset_models(Weather)),
    "clouds": NameKind("`light.sun.clouds`", _preset_models(Clouds)),
    "haze": NameKind("`light.haze`, and the strengths they stand for", _strengths(HAZES)),
    "scatter": NameKind("`terrain.scatter`: presets, with their species", _scatter),
    "species": NameKind("lists of `terrain.scatter`, with the presets that have them", _species),
    "water": NameKind("`terrain.water`", _preset_models(Water)),
    "waves": NameKind("`terrain.water.waves`, and the strengths they stand for", _strengths(WAVES)),
    "looks": NameKind("`film.look`", _preset_models(Look)),
    "titles": NameKind("`titles:`", _preset_models(Title)),
    "costumes": NameKind("`costume:` of people and dancers", _costumes),
    "presets": NameKind("`film.preset`, and `--preset`", _presets),
    "gaits": NameKind("`gait:` of walks and orders", _gaits),
    "moods": NameKind("`mood:` of creatures and orders", _moods),
    "verbs": NameKind("`do:` of the script, by who can", _verbs),
    "events": NameKind("`when:` of the script", _events),
    "characters": NameKind(
        "`character:` of the cast: people and things they play with", _characters
    ),
    "bodies": NameKind("`body: {shape: ...}` and `many:` of the cast, which fall", _bodies),
    "props": NameKind("`prop: {shape: ...}` of the cast, which the author moves", _props),
    "groups": NameKind("`group: {rule: ...}` of the cast", _groups),
    "behaviours": NameKind("`behaviours:` of characters, and `urge:`", _behaviours),
    "relations": NameKind("`story.relations` between people", _relations),
    "instruments": NameKind("`instrument:` of voices, by family", _instruments),
    "drums": NameKind("`drum:` of voices", _drums),
    "scales": NameKind("`scale:` of the sound, after a root as in `C minor`", _scales),
    "causes": NameKind("`cause:` of voices, and keys of `detect:`", _causes),
    "rooms": NameKind("`room:` of the sound", _rooms),
}
"""Kinds of names, by what `pronk list` calls them."""
