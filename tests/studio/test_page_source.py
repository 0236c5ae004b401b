"""The page's bundle: made of its source, of locked packages, with the licences of all of them."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from pipeline.studio.app import PAGE

PAGE_FOLDER = Path(str(PAGE))
SOURCE = PAGE_FOLDER / "source"


def locked() -> dict[str, dict[str, object]]:
    """Return the packages of the lock file by name."""
    packages = json.loads((SOURCE / "package-lock.json").read_text())["packages"]
    return {path.removeprefix("node_modules/"): entry for path, entry in packages.items() if path}


def test_the_lock_file_names_no_registry() -> None:
    assert "resolved" not in (SOURCE / "package-lock.json").read_text()
    assert all(entry["integrity"] for entry in locked().values())


def test_the_licences_of_all_bundled_packages_are_there() -> None:
    text = (PAGE_FOLDER / "licences.txt").read_text()
    bundled = {name: entry for name, entry in locked().items() if not entry.get("dev")}
    assert len(bundled) > 10
    for name, entry in bundled.items():
        assert f"{name} {entry['version']} ({entry['license']})" in text


@pytest.mark.nightly
def test_the_bundle_is_that_of_its_source(tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None or not (SOURCE / "node_modules" / "esbuild").is_dir():
        pytest.skip("no bundler: it needs Node, and `npm ci` in the page's source")
    build = json.loads((SOURCE / "package.json").read_text())["scripts"]["build"]
    command, *options = build.split(" && ")[0].split()
    made = tmp_path / "studio.js"
    options = [f"--outfile={made}" if "--outfile" in one else one for one in options]
    subprocess.run(
        [SOURCE / "node_modules" / ".bin" / command, *options],
        cwd=SOURCE,
        check=True,
        capture_output=True,
    )
    assert made.read_bytes() == (PAGE_FOLDER / "studio.js").read_bytes()
