"""Bill of materials: every package and every library within PyAV with its licence."""

from __future__ import annotations

import importlib.util
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

SCRIPT = Path(__file__).parents[1] / "requirements" / "bill_of_materials.py"

LINUX = (
    "libx264-d6533a8d.so.165",
    "libSvtAv1Enc-9393c086.so.4.1.0",
    "libxcb-shm-0be6dfbf.so.0.0.0",
)
MACOS = ("libx264.165.dylib", "libSvtAv1Enc.4.1.0.dylib", "libvpx.12.dylib")
WINDOWS = ("libx264-165-f3a909470ddc2d85ed21eda3d0fb7954.dll", "avcodec-62-984de33114b7fa38.dll")


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bill_of_materials", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def environment(folder: Path, *libraries: str, of: str = "av.libs") -> Path:
    """Make a folder of packages with pronk and libraries within PyAV."""
    info = folder / "pronk-1.2.3.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: pronk\nVersion: 1.2.3\n")
    (folder / of).mkdir(parents=True)
    for name in libraries:
        (folder / of / name).write_bytes(name.encode())
    return folder


def bill(*components: dict[str, Any]) -> dict[str, Any]:
    return {"metadata": {"component": {"name": "pronk"}}, "components": list(components)}


def av() -> dict[str, Any]:
    return {"name": "av", "licenses": [{"license": {"id": "BSD-3-Clause"}}]}


@pytest.mark.parametrize(
    ("names", "folder"), [(LINUX, "av.libs"), (MACOS, "av/.dylibs"), (WINDOWS, "av.libs")]
)
def test_libraries_within_pyav_have_name_version_digest_and_licence(
    script: ModuleType, tmp_path: Path, names: tuple[str, ...], folder: str
) -> None:
    done = script.completed(bill(av()), environment(tmp_path, *names, of=folder))
    assert done["metadata"]["component"]["version"] == "1.2.3"
    inside = {part["name"]: part for part in done["components"][0]["components"]}
    assert len(inside) == len(names)
    x264 = inside["x264"]
    assert x264["version"] == "165"
    assert x264["licenses"][0]["expression"] == "GPL-2.0-or-later"
    (file,) = (name for name in names if "x264" in name)
    assert x264["hashes"] == [{"alg": "SHA-256", "content": sha256(file.encode()).hexdigest()}]


def test_what_has_no_licence_is_told(script: ModuleType, tmp_path: Path) -> None:
    packages = environment(tmp_path, "libnews-d6533a8d.so.1")
    found = bill(av(), {"name": "OpenEXR"}, {"name": "other_package"})
    with pytest.raises(SystemExit) as stopped:
        script.completed(found, packages)
    assert str(stopped.value).splitlines() == [
        "error: libnews-d6533a8d.so.1 of av: add its licence to BUNDLED",
        "error: other-package: add its licence to UNDECLARED",
    ]
    assert found["components"][1]["licenses"][0]["expression"] == "BSD-3-Clause"


def test_the_licences_of_the_installed_pyav_are_known(script: ModuleType) -> None:
    import av as installed

    packages = Path(installed.__file__).parents[1]
    unknown: list[str] = []
    inside = {part["name"] for part in script.bundled_libraries(packages, unknown)}
    assert unknown == []
    if inside:  # a PyAV from source brings no libraries
        assert {"avcodec", "x264", "x265", "vpx", "SvtAv1Enc", "opus"} <= inside, version("av")
