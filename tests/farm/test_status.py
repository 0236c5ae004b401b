"""The status of a store: frames, rate, time left, failures, thumbnails."""

from __future__ import annotations

import base64
import io
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from pipeline.farm.frame_index import FrameIndex
from pipeline.farm.status import IDLE_SECONDS, measured_rate, statuses
from pipeline.farm.status_page import THUMBNAILS, StatusPage
from pipeline.farm.store import Store
from tests.farm.conftest import Farmed
from tests.production.conftest import FRAMES

Pronk = Callable[..., tuple[int, str, str]]


@pytest.fixture
def half(farmed: Farmed, tmp_path: Path) -> Farmed:
    """Return a store that lacks two frames, one of which was given up."""
    shutil.copytree(farmed.store.address.removeprefix("file://"), tmp_path / "store")
    store = Store(str(tmp_path / "store"))
    index = FrameIndex(store, farmed.film)
    for record in index.records([3, 6], None):
        index.forget(record)
    index.fail(6, "the renderer crashed: <killed>", 3)
    return Farmed(store, farmed.film)


def test_rates_are_those_of_the_latest_frames() -> None:
    assert measured_rate([]) is measured_rate([5.0]) is measured_rate([5.0, 5.0]) is None
    assert measured_rate([0.0, 10.0, 12.0, 14.0]) == pytest.approx(0.5)
    late = [float(n) for n in range(100)] + [100.0 + 0.1 * n for n in range(64)]
    assert measured_rate(late) == pytest.approx(10.0)


def test_a_film_under_way_is_told(half: Farmed) -> None:
    latest = max(FrameIndex(half.store, half.film).times().values())
    (found,) = statuses(half.store, latest + 1.0)
    assert (len(found.done), found.is_simulated) == (FRAMES - 2, True)
    assert found.rate is not None
    assert found.remaining == pytest.approx(2 / found.rate)
    assert found.failures == {6: "the renderer crashed: <killed>"}
    assert found.state == "given up: 6"
    (later,) = statuses(half.store, latest + IDLE_SECONDS + 1.0)
    assert later.rate is later.remaining is None


def test_the_command_prints_a_table_and_writes_a_page(
    half: Farmed, tmp_path: Path, pronk: Pronk
) -> None:
    page = tmp_path / "pages/status.html"
    code, out, _ = pronk("farm", "status", "--store", half.store.address, "--html", page)
    head, film, reason = out.splitlines()
    assert (code, head.split()) == (0, ["film", "frames", "rate", "left", "state"])
    assert film.startswith(f"tiny {half.film.key[:8]}  6 of 8 ")
    assert reason == "tiny, frame 6: the renderer crashed: <killed>"
    text = page.read_text()
    pictures = re.findall(r'src="data:image/jpeg;base64,([^"]+)"', text)
    assert len(pictures) == min(FRAMES - 2, THUMBNAILS)
    assert Image.open(io.BytesIO(base64.b64decode(pictures[0]))).size == (64, 36)
    assert "&lt;killed&gt;" in text
    assert "<killed>" not in text
    code, out, _ = pronk("farm", "status", "--store", half.store.address, "--json")
    (told,) = json.loads(out)["films"]
    assert (told["done"], told["frames"], list(told["failures"])) == (6, 8, ["6"])


def test_pictures_that_are_gone_do_not_stop_the_page(half: Farmed) -> None:
    index = FrameIndex(half.store, half.film)
    (record,) = index.records([1], None)
    half.store.remove(half.film.frame_object(record.key))
    text = StatusPage(half.store).text(statuses(half.store, 0.0), "now")
    assert "1: cannot be read" in text


def test_an_empty_store_is_told(tmp_path: Path, pronk: Pronk) -> None:
    code, out, _ = pronk("farm", "status", "--store", tmp_path / "none")
    assert (code, out.endswith("has no films\n")) == (0, True)
