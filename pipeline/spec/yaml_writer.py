"""YAML writer: a scene as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from pipeline.spec.file_references import file_names
from pipeline.spec.model_base import PathSegment
from pipeline.spec.scene import Scene
from pipeline.spec.yaml_scalars import scalar_of


def dump(scene: Scene, in_full: bool = True, files: Mapping[str, str] | None = None) -> str:
    """Return YAML text that loads to an equal scene; figures and dances stand in it.

    Args:
        scene: any scene.
        in_full: whether defaults are written too. A scene that simulates to the same bytes leaves
            them out: a heading that is given differs from none.
        files: names that replace those of files which the scene names, by these.
    """
    values = _listed(scene.model_dump(exclude_none=True, exclude_unset=not in_full))
    for path, name in file_names(scene):
        _replace(values, path, (files or {}).get(name, name))
    return yaml.dump(
        values, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None
    )


def _replace(values: Any, path: Sequence[PathSegment], name: str) -> None:
    *above, last = path
    for step in above:
        values = values[step]
    values[last] = name


def _listed(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _listed(below) for key, below in value.items()}
    return [_listed(item) for item in value] if isinstance(value, tuple | list) else value


class _Dumper(yaml.SafeDumper):
    """Writes no aliases, and quotes what our own rules would not read as text."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _text(dumper: _Dumper, text: str) -> yaml.ScalarNode:
    try:
        # Between single quotes a next line (U+0085) is folded into a blank.
        quoted = "\x85" in text or not isinstance(scalar_of(text), str)
    except ValueError:
        quoted = True
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"' if quoted else None)


_Dumper.add_representer(str, _text)
