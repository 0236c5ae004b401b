"""Bill of materials: completes the CycloneDX file of an environment that holds pronk.

cyclonedx-py lists the packages of an environment with the licences that they declare. What it
cannot know is added here: pronk's version, the licences of packages that declare none, and the
libraries that PyAV's wheel bundles, FFmpeg and its encoders, each with its licence and digest.

    python requirements/bill_of_materials.py BILL SITE_PACKAGES
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from hashlib import sha256
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

UNDECLARED = {"openexr": "BSD-3-Clause", "resvg-py": "MIT"}
"""Licences of packages whose metadata names none, from the licence files in their wheels."""

FFMPEG = "LGPL-3.0-or-later"
"""As its libraries answer: it is configured with `--enable-version3`."""

_GCC = "GPL-3.0-or-later WITH GCC-exception-3.1"
_EITHER = "LGPL-3.0-or-later OR GPL-2.0-or-later"
BUNDLED = {
    "SvtAv1Enc": "BSD-3-Clause-Clear",
    "Xau": "MIT-open-group",
    "asound": "LGPL-2.1-or-later",
    **dict.fromkeys(("avcodec", "avdevice", "avfilter", "avformat", "avutil"), FFMPEG),
    **dict.fromkeys(("swresample", "swscale"), FFMPEG),
    "dav1d": "BSD-2-Clause",
    "drm": "MIT",
    "gcc_s_seh": _GCC,
    "gmp": _EITHER,
    "gnutls": "LGPL-2.1-or-later",
    "hogweed": _EITHER,
    "iconv": "LGPL-2.1-or-later",
    "mp3lame": "LGPL-2.0-or-later",
    "nettle": _EITHER,
    "opencore-amrnb": "Apache-2.0",
    "opencore-amrwb": "Apache-2.0",
    "opus": "BSD-3-Clause",
    "sharpyuv": "BSD-3-Clause",
    "stdc++": _GCC,
    "unistring": _EITHER,
    "vpl": "MIT",
    "vpx": "BSD-3-Clause",
    "webp": "BSD-3-Clause",
    "webpmux": "BSD-3-Clause",
    "winpthread": "MIT AND BSD-3-Clause-Clear",
    "x264": "GPL-2.0-or-later",
    "x265": "GPL-2.0-or-later",
    **dict.fromkeys(("xcb", "xcb-shape", "xcb-shm", "xcb-xfixes"), "MIT"),
    "zlib1": "Zlib",
}
"""Licences of the libraries in PyAV's wheels, by the names of their files."""

_LIBRARY = re.compile(
    r"(?:lib)?(?P<name>.+?)(?:-[0-9a-f]{8,}|[-.](?P<version>\d[0-9.]*))*"
    r"\.(?:so|dylib|dll)(?:\.(?P<so_version>[0-9.]+))?"
)
"""File names of libraries in repaired wheels, such as `libx264-d6533a8d.so.165`."""


def completed(bill: dict[str, Any], site_packages: Path) -> dict[str, Any]:
    """Return a bill with pronk's version, all licences, and the libraries within PyAV.

    Args:
        bill: that cyclonedx-py made of the environment.
        site_packages: folder of the environment's packages.

    Raises:
        SystemExit: the licence of a package or library is unknown.
    """
    (pronk,) = distributions(name="pronk", path=[str(site_packages)])
    bill["metadata"]["component"]["version"] = pronk.version
    unknown = []
    for component in bill["components"]:
        name = component["name"].lower().replace("_", "-")
        if not component.get("licenses"):
            if name in UNDECLARED:
                component["licenses"] = licence(UNDECLARED[name])
            else:
                unknown.append(f"{name}: add its licence to UNDECLARED")
        if name == "av":
            component["components"] = list(bundled_libraries(site_packages, unknown))
    if unknown:
        raise SystemExit("error: " + "\nerror: ".join(unknown))
    return bill


def bundled_libraries(site_packages: Path, unknown: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the libraries within PyAV, in the order of their names.

    Args:
        site_packages: folder of the environment's packages.
        unknown: takes a line for each library of unknown licence.
    """
    # Linux and Windows; macOS.
    folders = (site_packages / "av.libs", site_packages / "av" / ".dylibs")
    for path in sorted(path for folder in folders for path in folder.glob("*")):
        match = _LIBRARY.fullmatch(path.name)
        if match is None or match["name"] not in BUNDLED:
            unknown.append(f"{path.name} of av: add its licence to BUNDLED")
            continue
        version = match["version"] or match["so_version"]
        yield {
            "type": "library",
            "bom-ref": f"av/{path.name}",
            "name": match["name"],
            **({"version": version} if version else {}),
            "hashes": [{"alg": "SHA-256", "content": sha256(path.read_bytes()).hexdigest()}],
            "licenses": licence(BUNDLED[match["name"]]),
        }


def licence(expression: str) -> list[dict[str, Any]]:
    """Return an SPDX expression as CycloneDX has it."""
    return [{"expression": expression, "acknowledgement": "concluded"}]


def main(bill: Path, site_packages: Path) -> None:
    """Complete a bill in its place and check it against the schema."""
    # From the maintainers' environment, which the tests do not have.
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    done = completed(json.loads(bill.read_text(encoding="utf-8")), site_packages)
    text = json.dumps(done, indent=2, ensure_ascii=False) + "\n"
    fault = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
    if fault is not None:
        raise SystemExit(f"error: {bill}: {fault}")
    bill.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
