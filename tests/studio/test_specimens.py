"""Pictures and sounds of the library, and scenes that begin with its entries."""

from __future__ import annotations

import io
import wave
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline.errors import UsageError
from pipeline.simulation.simulate import Simulation
from pipeline.spec import library, load_figure, read_scene
from pipeline.spec.name_catalogue import names_of
from pipeline.studio.project import Project
from pipeline.studio.specimens import SIZE, TEXTS, Specimens, specimen_text
from tests.studio.conftest import Served

EACH = [(kind, entry.name) for kind in TEXTS for entry in names_of(f"{kind}s", library())]


@pytest.fixture
def specimens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Specimens:
    """Those of an empty folder, with an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    project = Project.at(tmp_path)
    return Specimens(project.read, lambda: project.folder)


@pytest.mark.sample(8)
@pytest.mark.parametrize(("kind", "name"), EACH, ids=[f"{kind} {name}" for kind, name in EACH])
def test_a_scene_with_each_entry_of_the_library_is_right(kind: str, name: str) -> None:
    scene = read_scene(specimen_text(kind, name, library()), "scene", library())
    assert scene.cast[0].name in ("ball", "anna", "bug")


@pytest.mark.parametrize("kind", ["material", "figure", "light"])
def test_what_the_library_does_not_have_is_refused(kind: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=f"the library has no {kind} 'unobtainium'"):
        specimen_text(kind, "unobtainium", tmp_path)


def test_new_documents_begin_with_entries(served: Served) -> None:
    status, document = served.ask("new-from", kind="drum", source="cowbell", name="bells")
    assert (status, document["name"]) == (200, "bells.yaml")
    assert 'title: "Bells"' in document["text"]
    assert "drum: cowbell" in document["text"]
    horse = "library:figures/horse.yaml"
    status, document = served.ask("new-from", kind="figure", source=horse, name="mare")
    assert (status, document["name"]) == (200, "figures/mare.yaml")
    assert load_figure(served.folder / "figures" / "mare.yaml").style == "mammal"
    toy = "library:toy.yaml"
    assert served.ask("new-from", kind="scene", source=toy, name="mine")[0] == 200
    assert (served.folder / "mine.yaml").read_bytes() == (library() / "toy.yaml").read_bytes()
    status, answer = served.ask("new-from", kind="figure", source=toy, name="mine/../../x")
    assert status == 422
    status, answer = served.ask("new-from", kind="drum", source="cowbell", name="mine")
    assert status == 422
    assert "already" in answer["error"]


@pytest.mark.nightly
def test_pictures_and_sounds_are_made_once(
    specimens: Specimens, monkeypatch: pytest.MonkeyPatch
) -> None:
    brass, oak = (specimens.picture("material", name) for name in ("brass", "oak"))
    pixels = [np.asarray(Image.open(io.BytesIO(one))).astype(int) for one in (brass, oak)]
    assert pixels[0].shape == (SIZE[1], SIZE[0], 3)
    assert np.abs(pixels[0] - pixels[1]).max() > 20
    beetle = specimens.picture("figure", "library:figures/beetle.yaml")
    assert Image.open(io.BytesIO(beetle)).size == SIZE
    heard = [specimens.sound("drum", name) for name in ("cowbell", "hand clap")]
    assert heard[0] != heard[1]
    with wave.open(io.BytesIO(heard[0])) as track:
        assert track.getnframes() / track.getframerate() == pytest.approx(5, abs=0.1)
        assert max(track.readframes(track.getnframes())) > 0
    monkeypatch.setattr(Simulation, "step", lambda _: pytest.fail("it is simulated again"))
    again = Specimens(specimens._read, specimens._folder)
    assert again.picture("material", "oak") == oak
    assert again.sound("drum", "cowbell") == heard[0]


def test_a_kind_without_sound_is_refused(specimens: Specimens) -> None:
    with pytest.raises(UsageError, match="no sound stands for a dance"):
        specimens.sound("dance", "waving")
    with pytest.raises(UsageError, match="is no figure"):
        specimens.picture("figure", "library:toy.yaml")
