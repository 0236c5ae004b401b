"""Motion blur: the mean over the exposure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from render.config import Film
from render.renderer import Renderer
from render.shot import CameraPose, Moment, Shot

Make = Callable[..., Shot]

FROM, TO = -1.2, 1.2
"""Distance that the body moves while the shutter is open [m]."""


def exposed(make_shot: Make, moments: int, samples: int, seed: int = 0) -> Shot:
    """Return a shot of a moving body, exposed at a number of moments."""
    film = Film(size=(64, 48), samples=samples, depth=3, denoise="off")
    shots = [
        make_shot(x=FROM + (TO - FROM) * (k + 0.5) / moments, film=film, seed=seed)
        for k in range(moments)
    ]
    later = tuple(Moment(shot.meshes, shot.camera) for shot in shots[1:])
    return replace(shots[0], later=later)


def light_of(renderer: Renderer, shot: Shot) -> NDArray[np.float32]:
    return renderer.render(shot).light


@pytest.mark.nightly
def test_a_still_scene_looks_as_without_blur(renderer: Renderer, make_shot: Make) -> None:
    """The samples of a frame are spread over its moments, and none is taken twice."""
    still = make_shot(film=Film(size=(64, 48), samples=12, depth=3, denoise="off"))
    shared = replace(still, later=(still.moments[0],) * 2)
    np.testing.assert_allclose(
        light_of(renderer, shared), light_of(renderer, still), rtol=1e-4, atol=1e-6
    )


@pytest.mark.slow
@pytest.mark.nightly
def test_a_moving_body_is_visible_at_every_moment(renderer: Renderer, make_shot: Make) -> None:
    """A pixel with the body in one of two moments is half ground."""
    shot = exposed(make_shot, 2, 128)
    blurred = light_of(renderer, shot)
    alone = [
        light_of(renderer, replace(shot, meshes=moment.meshes, later=())) for moment in shot.moments
    ]
    assert np.abs(alone[0] - alone[1]).max() > 0.2
    assert np.abs(blurred - np.mean(alone, axis=0)).mean() < 0.01


@pytest.mark.nightly
def test_more_moments_converge_to_the_continuous_blur(renderer: Renderer, make_shot: Make) -> None:
    whole = light_of(renderer, exposed(make_shot, 64, 4096))
    errors = []
    for moments in (2, 4, 8, 16):
        seen = light_of(renderer, exposed(make_shot, moments, 2048))
        errors.append(float(np.sqrt(np.mean((seen - whole) ** 2))))
    # Where edges step over pixels the error falls with the square root of the moments, or faster.
    assert all(after < 0.75 * before for before, after in pairwise(errors))


@pytest.mark.nightly
def test_a_still_scene_is_no_noisier(renderer: Renderer, make_shot: Make) -> None:
    """The moments share the samples of a frame; where nothing moves nothing is lost."""

    def noise(moments: int) -> NDArray[np.float64]:
        seen = [light_of(renderer, exposed(make_shot, moments, 16, seed)) for seed in range(40, 56)]
        deviation: NDArray[np.float64] = np.std(np.array(seen, np.float64), axis=0)
        return deviation

    still = np.s_[36:, :24]
    single, shared = noise(1)[still].mean(), noise(4)[still].mean()
    # Strata of four times fewer samples are coarser.
    assert shared < 1.6 * single


def test_every_moment_is_in_the_digest(make_shot: Make) -> None:
    shot = exposed(make_shot, 3, 3)
    pose = CameraPose((3.0, 2.0, 4.0), (0.0, 0.35, 0.0))
    others = [
        replace(shot, later=()),
        replace(shot, later=shot.later[:1]),
        replace(shot, later=shot.later[::-1]),
        replace(shot, later=(shot.later[0], replace(shot.later[1], camera=pose))),
    ]
    assert len({shot.digest, *(other.digest for other in others)}) == 5
    assert {other.build for other in others} == {shot.build}


@pytest.mark.parametrize(
    ("config", "exposures"),
    [
        ({"shutter_deg": 0, "moments": 8}, (0.0,)),
        ({"shutter_deg": 360, "moments": 2, "samples": 8}, (0.25, 0.75)),
        ({"shutter_deg": 180, "moments": 4, "samples": 2}, (0.125, 0.375)),
        ({"preset": "draft"}, (0.0,)),
    ],
)
def test_moments_are_the_centres_of_equal_intervals(
    config: dict[str, object], exposures: tuple[float, ...]
) -> None:
    assert Film.model_validate(config).resolved().exposures == pytest.approx(exposures)
