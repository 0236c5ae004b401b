"""Cut list: what it prints is a block `camera` of a scene, and the manifest lists the same."""

from __future__ import annotations

import json

import pytest
import yaml

from render.config.camera import cuts

pytestmark = pytest.mark.nightly


@pytest.mark.nightly
def test_the_cuts_of_a_director_can_stand_in_the_scene(studio, pronk) -> None:
    code, out, _ = pronk("cuts", "tiny", "--set", "camera=auto", cwd=studio.folder)
    assert code == 0
    assert "# one shot of all" in out
    (camera,) = cuts(yaml.safe_load(out)["camera"])
    assert camera.auto is None
    assert camera.view is not None
    (entry,) = json.loads((studio.folder / "out/tiny/manifest.json").read_text())["cuts"]
    assert "one shot of all" in entry.pop("reason")
    assert cuts(entry) == (camera,)
    path = studio.folder / "tiny.yaml"
    text = path.read_text().replace("camera: {follow: bug}\n", out)
    path.write_text(text)
    code, out, _ = pronk("cuts", "tiny", "--json", cwd=studio.folder)
    assert code == 0
    assert cuts(json.loads(out.splitlines()[-1])["cuts"]) == (camera,)


def test_the_cuts_of_an_author_are_printed_as_they_are(studio, pronk) -> None:
    code, out, _ = pronk("cuts", "tiny", cwd=studio.folder)
    assert (code, yaml.safe_load(out)) == (0, {"camera": [{"start": 0.0, "follow": "bug"}]})
    code, _, err = pronk("cuts", "tiny", "--set", "camera=atuo", cwd=studio.folder)
    assert code != 0
    assert "did you mean 'auto'" in err
