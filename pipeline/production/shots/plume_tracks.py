"""Plume tracks: the fires of a scene, and their smoke, at any row of its take.

A group of the rule `fire` is simulated as separate flames. Of the material `flame`, or another
that glows, it is shown as flames of one fire, and of the material `smoke` as smoke; its separate
flames are then not shown. Of other materials they are shown as they are.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from pipeline.production.camera.parent_nodes import resolve_parents
from pipeline.production.shots.skinning import interpolated_poses
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take
from pipeline.spec.group import Fire, Group
from pipeline.spec.scene import Scene
from render.color import linear
from render.config import Lamp
from render.exposure_meter import daylight
from render.plume import Plume
from render.shot import LampPlace

GLOW = 11.0
"""Radiance of the middle of flames at night."""
DAY_SHARE = 0.3
"""The same by day, as a share: the picture is exposed for the sun."""

LAMP_BRIGHTNESS, LAMP_POWER = 13.0, 0.6
"""Brightness of the light of a fire of one square metre, and its growth with the size."""
LAMP_DAY_SHARE = 0.06
"""Light of a fire by day, as a share of that at night."""
_LAMP_HEIGHTS = (0.3, 0.62)
"""Heights of the two lamps of a fire, in heights of its flames."""
_FLICKER, _FLICKER_RATE = 0.32, 7.0
"""Amplitude and frequency of the flickering [Hz]."""
_BEHIND = 0.55
"""Share of the motion of a torch that its flames lag behind."""


@dataclass(frozen=True, eq=False)
class _Source:
    """A place that flames or smoke rise from.

    Attributes:
        plume: at rest.
        place: (3,) relative to its parent [m].
        node: number of the parent's node, -1 for the world.
        performer: name.
    """

    plume: Plume
    place: Array
    node: int
    performer: str


@dataclass(frozen=True, eq=False)
class PlumeTracks:
    """All fires and smoke of a scene.

    Attributes:
        sources: in the order of the cast.
        lamps: two for each fire, invisible, which light what is around it.
    """

    sources: tuple[_Source, ...]
    lamps: tuple[Lamp, ...]

    @staticmethod
    def of(scene: Scene, take: Take) -> PlumeTracks:
        """Return the fires of a scene.

        Raises:
            SceneError: the parent of one does not exist.
        """
        names = NodeNames.of(take)
        sources = []
        night = 1.0 - daylight(scene.light)
        glow = GLOW * (DAY_SHARE + (1.0 - DAY_SHARE) * night)
        for i, member in enumerate(scene.cast):
            if not isinstance(member, Group) or not isinstance(member.group, Fire):
                continue
            material = scene.material(member.material or "flame")
            is_smoke = material.preset == "smoke" or member.material == "smoke"
            if material.glow == 0.0 and not is_smoke:
                continue
            (node,) = resolve_parents(scene, names, {f"cast[{i}]": member.parent})
            r, g, b = linear(material.color).tolist()
            fire = member.group
            plume = Plume(
                "smoke" if is_smoke else "flame",
                (0.0, 0.0, 0.0),
                radius=max(fire.radius + 0.5 * fire.size, 0.01),
                height=fire.height * (1.0 if is_smoke else 1.3),
                # Gas outruns the flames that it carries.
                speed=1.5 * fire.height / fire.life,
                wind=fire.wind,
                color=(r, g, b),
                glow=0.0 if is_smoke else glow,
                seed=(scene.seed + zlib.crc32(member.name.encode())) % 100_003,
            )
            sources.append(_Source(plume, _place(member, take), node, member.name))
        lamps = [
            lamp for source in sources for lamp in _lamps(source.plume, night) if source.plume.glow
        ]
        return PlumeTracks(tuple(sources), tuple(lamps))

    @property
    def performers(self) -> frozenset[str]:
        """Names of the groups whose flames are not shown one by one."""
        return frozenset(source.performer for source in self.sources)

    def placed(self, take: Take, at: float) -> tuple[Plume, ...]:
        """Return the plumes at a row of the take or between two."""
        if not self.sources:
            return ()
        q, p, _ = interpolated_poses(take, at)
        before = max(at - 1.0, 0.0)
        q0, p0, _ = interpolated_poses(take, before)
        seconds = (at - before) / float(take.header.rate * take.header.samples)
        placed = []
        for source in self.sources:
            plume, node = source.plume, source.node
            if node < 0:
                place, velocity = source.place, np.zeros(3)
            else:
                place = p[node] + matrix(q[node]) @ source.place
                was = p0[node] + matrix(q0[node]) @ source.place
                velocity = (place - was) / seconds if seconds else np.zeros(3)
            x, y, z = (float(v) for v in place)
            wind = (
                plume.wind[0] - _BEHIND * float(velocity[0]),
                plume.wind[1] - _BEHIND * float(velocity[2]),
            )
            placed.append(
                Plume(
                    *(plume.kind, (x, y, z), plume.radius, plume.height, plume.speed, wind),
                    *(plume.color, plume.glow, plume.seed),
                )
            )
        return tuple(placed)


def fire_lamps(plumes: tuple[Plume, ...], time: float) -> tuple[LampPlace, ...]:
    """Return where the lamps of fires are at a time [s], and how bright they flicker."""
    places = []
    for plume in plumes:
        if plume.kind != "flame":
            continue
        x, y, z = plume.p_WP
        for k, share in enumerate(_LAMP_HEIGHTS):
            draws = [_wander(_FLICKER_RATE * time, plume.seed + 10 * k + j) for j in range(3)]
            up = share * plume.height
            side = 0.35 * plume.radius
            bend = up / max(plume.speed, 0.05) * 0.6
            place = (
                x + side * draws[0] + plume.wind[0] * bend,
                y + up * (1.0 + 0.12 * draws[2]),
                z + side * draws[1] + plume.wind[1] * bend,
            )
            places.append(LampPlace(place, None, 1.0 + _FLICKER * draws[2]))
    return tuple(places)


def _lamps(plume: Plume, night: float) -> tuple[Lamp, ...]:
    share = LAMP_DAY_SHARE + (1.0 - LAMP_DAY_SHARE) * night
    size = plume.radius * plume.height
    bright = share * LAMP_BRIGHTNESS * size**LAMP_POWER / len(_LAMP_HEIGHTS)
    r, g, b = plume.color
    # As the flames look from afar: those of the preset like candlelight.
    high = max(r, g, b, 1e-6)
    color = tuple(float(min((c / high) ** (1 / 2.2), 1.0)) for c in (r, 1.6 * g, 2.2 * b))
    return tuple(Lamp(brightness=bright, color=color, radius=0.0) for _ in _LAMP_HEIGHTS)


def _wander(x: float, seed: int) -> float:
    """Return a smooth random course, -1 to 1, that changes about once for each unit of `x`."""
    i = int(np.floor(x))
    t = x - i
    t = t * t * (3.0 - 2.0 * t)
    a, b = (np.random.default_rng([seed, i + k]).uniform(-1.0, 1.0) for k in (0, 1))
    return float(a + t * (b - a))


def _place(member: Group, take: Take) -> Array:
    """Return where flames come from (3,) [m], relative to what carries them."""
    if len(member.at) == 3:
        return np.array(member.at, float)
    x, z = member.at
    if member.parent is not None:
        return np.array([x, 0.0, z])
    mine = [i for i, node in enumerate(take.nodes) if node.performer == member.name]
    # Flames begin on the ground below `at`.
    return np.array([x, float(np.min(take.positions[0][mine][:, 1])), z])
