"""Scene course: tension and motion of a take, which generated music follows."""

from __future__ import annotations

import numpy as np

from audio.music.scene_course import SceneCourse
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take

# Values a second, and the time over which they are smoothed [s].
_RATE, _SMOOTHNESS = 4, 1.5
# Speed of a performer at which half of the motion is reached [m/s], and events a second.
_HALF_SPEED, _HALF_EVENTS = 1.6, 6.0
# Speed of an impact at which half of the tension is reached [m/s]; tension of the quickest pace.
_HALF_IMPACT, _PACE = 4.0, 0.8
_STEPS = 1000


def scene_course(take: Take) -> SceneCourse:
    """Return how tense and how lively a take is.

    Motion is that of speeds and of the number of events. Tension is the greatest of the anxiety of
    all minds, of hard impacts, and of a quick pace.
    """
    header = take.header
    count = max(int(np.ceil(float(header.frames / header.rate) * _RATE)), 1)
    events = [event for event in take.events if event.frame <= header.frames]
    places = [min(int((event.frame - 1) / header.rate * _RATE), count - 1) for event in events]
    heard = np.bincount(places, minlength=count).astype(np.float64) * _RATE
    motion = np.maximum(
        _share(_smooth(heard), _HALF_EVENTS), _share(_smooth(_speeds(take, count)), _HALF_SPEED)
    )
    impacts = np.zeros(count)
    np.maximum.at(impacts, places, [event.strength for event in events])
    tension = np.maximum(_anxieties(take, count), _share(impacts, _HALF_IMPACT))
    tension = np.maximum(tension, _PACE * motion**2)
    return SceneCourse(1 / _RATE, _rounded(_smooth(tension)), _rounded(motion))


def _rows(take: Take, count: int) -> Array:
    """Return the rows of a take at even times: (count,)."""
    step = float(take.header.rate * take.header.samples) / _RATE
    return np.minimum((np.arange(count) * step).astype(np.int64), take.positions.shape[0] - 1)


def _speeds(take: Take, count: int) -> Array:
    """Return the mean speed of the nodes that are there and move at all [m/s]: (count,)."""
    if take.positions.shape[1] == 0:
        return np.zeros(count)
    rows = _rows(take, count + 1)
    places, alive = np.nan_to_num(np.asarray(take.positions)[rows]), np.asarray(take.alive)[rows]
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=2) * _RATE
    # Raindrops that fall again jump back while they are hidden.
    moving = (speeds > 0.02) & alive[1:] & alive[:-1]
    return np.asarray((speeds * moving).sum(axis=1) / np.maximum(moving.sum(axis=1), 1))


def _anxieties(take: Take, count: int) -> Array:
    """Return the greatest anxiety of all minds: (count,); 0 without any."""
    columns = [k for k, each in enumerate(take.channels) if each.name.endswith(".anxiety")]
    if not columns:
        return np.zeros(count)
    values = np.nan_to_num(np.asarray(take.values)[_rows(take, count)][:, columns])
    return np.asarray(np.clip(values, 0.0, 1.0).max(axis=1))


def _share(values: Array, half: float) -> Array:
    return np.asarray(values / (values + half))


def _smooth(values: Array) -> Array:
    reach = round(_SMOOTHNESS * _RATE)
    window = np.hanning(2 * reach + 1)
    padded = np.pad(values, reach, mode="edge")
    return np.asarray(np.convolve(padded, window / window.sum(), "valid"))


def _rounded(values: Array) -> tuple[float, ...]:
    # The last bits differ between classes of processor, and music must not.
    return tuple((np.rint(values * _STEPS) / _STEPS).tolist())
