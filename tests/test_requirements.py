"""Pinned packages: every file of `requirements` against pyproject.toml, and free of addresses."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "requirements"
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
NAMES = ("runtime", *PROJECT["dependency-groups"])

PYTHONS = ("3.11", "3.12", "3.13", "3.14")
PLATFORMS = (
    {"sys_platform": "linux", "platform_machine": "x86_64"},
    {"sys_platform": "linux", "platform_machine": "aarch64"},
    {"sys_platform": "darwin", "platform_machine": "arm64"},
    {"sys_platform": "win32", "platform_machine": "AMD64"},
)

# A pin, its hashes, and a comment that says what asks for it.
_PIN = re.compile(
    r"([a-z0-9-]+==\S+(?: ; [^\n\\]+)?) \\\n((?:    --hash=[^\n]+\n)+)    # via [^\n]+\n"
)
_HASHES = re.compile(r"(?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+")


def environments() -> Iterator[dict[str, str]]:
    for python in PYTHONS:
        for platform in PLATFORMS:
            yield {"python_version": python, "python_full_version": f"{python}.0", **platform}


def pins(name: str) -> list[Requirement]:
    text = (FOLDER / f"{name}.txt").read_text()
    return [Requirement(pin) for pin, _ in _PIN.findall(text)]


def asked(name: str) -> list[Requirement]:
    if name == "runtime":
        return [Requirement(text) for text in PROJECT["project"]["dependencies"]]
    group = PROJECT["dependency-groups"][name]
    inner = [one for entry in group if isinstance(entry, dict) for one in asked(*entry.values())]
    return inner + [Requirement(entry) for entry in group if isinstance(entry, str)]


def applies(marker: Marker | None, environment: dict[str, str]) -> bool:
    return marker is None or marker.evaluate(environment)


def test_every_group_of_packages_has_its_file() -> None:
    assert {path.name for path in FOLDER.glob("*.txt")} == {f"{name}.txt" for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_a_file_is_pins_with_hashes_and_nothing_else(name: str) -> None:
    text = (FOLDER / f"{name}.txt").read_text()
    rest = _PIN.sub("", text)
    assert all(line.startswith("#") for line in rest.splitlines()), rest
    assert all(_HASHES.fullmatch(hashes) for _, hashes in _PIN.findall(text))
    # Versions and hashes only: where files come from is for pip's settings to say.
    assert "://" not in text
    assert not re.search(r"^\s*-[^-]|--(?!hash)|\.(?:org|com|net|io)\b", text, re.MULTILINE)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_asked_for_is_pinned_everywhere(name: str) -> None:
    for environment in environments():
        here = {
            canonicalize_name(pin.name): pin
            for pin in pins(name)
            if applies(pin.marker, environment)
        }
        for wanted in asked(name):
            if applies(wanted.marker, environment):
                (version,) = (one.version for one in here[canonicalize_name(wanted.name)].specifier)
                assert version in wanted.specifier, (wanted, environment)


def test_a_package_is_pinned_alike_in_all_files() -> None:
    versions: dict[str, set[str]] = {}
    for name in NAMES:
        for pin in pins(name):
            versions.setdefault(pin.name, set()).add(str(pin.specifier))
    assert {name for name, found in versions.items() if len(found) > 1} == set()


def test_the_build_backend_is_pinned() -> None:
    names = {canonicalize_name(pin.name) for pin in pins("build")}
    wanted = {canonicalize_name(Requirement(t).name) for t in PROJECT["build-system"]["requires"]}
    assert wanted <= names
    assert PROJECT["build-system"]["requires"][0] in PROJECT["dependency-groups"]["build"]
