"""Encoder check: whether this machine can encode a scene's film, known before rendering."""

from __future__ import annotations

from pipeline.errors import Problem, SceneError
from pipeline.spec import Scene
from render.errors import EncodeError
from render.film_codecs import find_codec


def require_encoders(scene: Scene) -> None:
    """Refuse a scene whose film cannot be encoded here.

    Raises:
        SceneError: the installed PyAV lacks an encoder of `film.codec`.
    """
    try:
        find_codec(scene.film.resolved().codec)
    except EncodeError as error:
        problem = Problem("film.codec", str(error))
        raise scene.source_map.with_locations(SceneError([problem])) from None
