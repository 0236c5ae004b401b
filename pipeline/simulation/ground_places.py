"""Ground places: where performers of a scene start and go to, which must lie on its terrain.

Bodies may fall over its edge, flocks fly past it, and props stand and move where their author puts
them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.group import Group
from pipeline.spec.model_base import Point
from pipeline.spec.scene import Scene
from pipeline.spec.script import Carry, GoTo, Instruction, JumpOnce
from pipeline.spec.yaml_tree import path_text


@dataclass(frozen=True, slots=True)
class GroundPlace:
    """A place on the ground that a scene names.

    Attributes:
        path: of its value in the scene.
        point: (x, z) [m].
        name: of a named place.
    """

    path: str
    point: Point
    name: str = ""


class GroundPlaces:
    """The places on the ground that performers start at and are sent to.

    Args:
        scene: the scene.
        ground: its terrain.
        places: named places (3,) of the scene [m].
    """

    def __init__(self, scene: Scene, ground: Ground, places: Mapping[str, Array]) -> None:
        self._scene, self._ground, self._places = scene, ground, places
        # A flock flies past the edge of the ground.
        self._flying = {member.name for member in scene.cast if isinstance(member, Group)}

    def refuse_off_terrain(self) -> None:
        """Refuses start places, paths, landings and destinations outside of the terrain.

        Raises:
            SceneError: if there are any; holds the problems of all.
        """
        places = [*self._of_cast()]
        for path, instruction in self._scene.instructions:
            places += self._of_order(instruction, path_text(path))
        self._refuse(places)

    def refuse_order(self, instruction: Instruction, path: str) -> None:
        """Refuses an instruction that leads off the terrain.

        Raises:
            SceneError: if it does.
        """
        self._refuse([*self._of_order(instruction, path)])

    def _refuse(self, places: list[GroundPlace]) -> None:
        points = np.array([place.point for place in places], dtype=float).reshape(-1, 2)
        is_inside = self._ground.field.inside(points[:, 0], points[:, 1])
        problems = [
            Problem(place.path, self._message(place))
            for place, lies_on_it in zip(places, is_inside.tolist(), strict=True)
            if not lies_on_it
        ]
        if problems:
            raise SceneError(problems)

    def _message(self, place: GroundPlace) -> str:
        x, z = place.point
        named = f"'{place.name}', at [{x:g}, {z:g}]," if place.name else f"[{x:g}, {z:g}]"
        extent = self._ground.field.extent_text
        return f"{named} lies outside the terrain, {extent}; make the terrain larger, or move it"

    def _of_cast(self) -> Iterator[GroundPlace]:
        for i, member in enumerate(self._scene.cast):
            path = f"cast[{i}]"
            if member.parent is not None:
                continue
            if isinstance(member, Creature | Dancer) or (
                isinstance(member, Character) and member.acts
            ):
                yield GroundPlace(f"{path}.at", (member.at[0], member.at[-1]))
            if isinstance(member, Creature):
                for k, point in enumerate(member.walk.path if member.walk else ()):
                    yield GroundPlace(f"{path}.walk.path[{k}]", point)
                for k, point in enumerate(member.pronk.land_at if member.pronk else ()):
                    yield GroundPlace(f"{path}.pronk.land_at[{k}]", point)

    def _of_order(self, instruction: Instruction, path: str) -> Iterator[GroundPlace]:
        order, path = instruction.do, f"{path}.do"
        if isinstance(order, JumpOnce) and order.jump.land_at is not None:
            yield GroundPlace(f"{path}.jump.land_at", order.jump.land_at)
        if isinstance(order, GoTo | Carry) and instruction.who not in self._flying:
            key, goal = ("go_to", order.go_to) if isinstance(order, GoTo) else ("to", order.to)
            if not isinstance(goal, str):
                yield GroundPlace(f"{path}.{key}", goal)
            elif goal in self._places:
                x, _, z = self._places[goal].tolist()
                yield GroundPlace(f"{path}.{key}", (x, z), goal)
