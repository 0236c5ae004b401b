"""Films of several segments are told from films of one."""

from __future__ import annotations

from fractions import Fraction

import pytest

from render import film_segments
from render.film_file import film_key
from tests.production.conftest import Studio


@pytest.mark.slow
def test_a_film_of_other_segments_is_encoded_again(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = studio.made / "tiny.mp4"
    one, before = film_key(film), film.read_bytes()
    monkeypatch.setattr(film_segments, "SEGMENT_SECONDS", Fraction(3, 24))
    studio.render()
    assert film_key(film) not in (one, None)
    state = studio.state()
    studio.render()
    assert studio.changes(state) <= {"manifest.json"}
    monkeypatch.undo()
    studio.render()
    assert film.read_bytes() == before
