"""Stored modes: solved once, the same from the file, and solved again where it is damaged."""

import numpy as np
import pytest

from audio import elastic_modes
from audio.elastic_modes import body_modes
from audio.mode_store import FOLDER


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    body_modes.cache_clear()
    yield tmp_path / "pronk" / FOLDER
    body_modes.cache_clear()


BODY = ("box", 0.25, 0.0625, 0.0, 0.3)


def test_a_body_is_solved_once_and_its_file_says_the_same(folder, monkeypatch):
    solved = body_modes(*BODY)
    assert len(list(folder.glob("*/*"))) == 1
    body_modes.cache_clear()
    monkeypatch.setattr(elastic_modes, "_solved", None)
    read = body_modes(*BODY)
    assert np.array_equal(read.omega, solved.omega)
    assert np.array_equal(read.displacement, solved.displacement)


def test_a_damaged_file_is_solved_again_and_mended(folder):
    solved = body_modes(*BODY)
    (file,) = folder.glob("*/*")
    whole = file.read_bytes()
    file.write_bytes(whole[:-8])
    body_modes.cache_clear()
    assert np.array_equal(body_modes(*BODY).omega, solved.omega)
    assert file.read_bytes() == whole


def test_a_folder_that_cannot_be_written_only_costs_time(folder):
    folder.parent.mkdir(parents=True)
    folder.write_text("a file")
    assert body_modes(*BODY).omega.size > 10
