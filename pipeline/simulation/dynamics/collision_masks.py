"""Collision masks: which bodies and kinematic bodies of a MuJoCo model meet, changed between steps.

Every body and kinematic body has one geom. A group of kinematic bodies has a bit of its own, so
that one body can pass through it while all others meet it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.errors import SimulationError
from pipeline.simulation.dynamics.mujoco_bodies import BODY_BIT, FIXED_BIT

FIRST_GROUP_BIT, LAST_BIT = 2, 30
"""Positions of the bits of groups; MuJoCo's masks are signed integers of 32 bits."""

SEARCH_DISTANCE = 1e-3
"""Distance beyond which two geoms are simply apart [m]."""


class CollisionMasks:
    """The masks of one model.

    Args:
        model: of MuJoCo.
        data: its state.
        mujoco: the module.
        bodies: number of bodies; kinematic bodies follow them.
    """

    def __init__(self, model: Any, data: Any, mujoco: Any, bodies: int) -> None:
        self._model, self._data, self._mujoco, self._count = model, data, mujoco, bodies
        pushers = model.nbody - 1 - bodies
        self._geoms = model.body_geomadr[1:].astype(np.int64)
        self._own_bits = np.full(pushers, FIXED_BIT)
        self._met_bits = np.full(bodies, BODY_BIT | FIXED_BIT)
        self._is_present = np.ones(bodies + pushers, dtype=bool)
        self._groups: list[Sequence[int]] = []

    def show_body(self, body: int, is_present: bool) -> None:
        """Lets a body meet others, or nothing."""
        self._is_present[body] = is_present
        met = int(self._met_bits[body]) if is_present else 0
        self._set(body, BODY_BIT if is_present else 0, met)

    def show_pusher(self, pusher: int, is_present: bool) -> None:
        """Lets a kinematic body push bodies, or none."""
        self._is_present[self._count + pusher] = is_present
        self._set(self._count + pusher, int(self._own_bits[pusher]) if is_present else 0, 0)

    def add_group(self, pushers: Sequence[int]) -> int:
        """Makes a group of kinematic bodies; returns its number.

        Raises:
            SimulationError: if there are more groups than bits.
        """
        number = len(self._groups)
        bit = FIRST_GROUP_BIT + number
        if bit > LAST_BIT:
            raise SimulationError(
                f"more than {LAST_BIT - FIRST_GROUP_BIT + 1} performers hold things; use fewer"
            )
        self._groups.append(pushers)
        self._own_bits[list(pushers)] = 1 << bit
        self._met_bits |= 1 << bit
        for pusher in pushers:
            self.show_pusher(pusher, bool(self._is_present[self._count + pusher]))
        for body in range(self._count):
            self.show_body(body, bool(self._is_present[body]))
        return number

    def set_meeting(self, body: int, group: int, meets: bool) -> None:
        """Lets a body meet a group, or pass through it."""
        bit = 1 << (FIRST_GROUP_BIT + group)
        self._met_bits[body] = self._met_bits[body] | bit if meets else self._met_bits[body] & ~bit
        self.show_body(body, bool(self._is_present[body]))

    def depth(self, body: int, group: int) -> float:
        """Returns how deep a body is in a group [m], negative where they are apart."""
        self._mujoco.mj_kinematics(self._model, self._data)
        own, fromto = int(self._geoms[body]), np.zeros(6)
        return -min(
            self._mujoco.mj_geomDistance(
                self._model, self._data, own, int(self._geoms[self._count + pusher]),
                SEARCH_DISTANCE, fromto,
            )
            for pusher in self._groups[group]
        )  # fmt: skip

    def _set(self, thing: int, contype: int, conaffinity: int) -> None:
        geom = self._geoms[thing]
        self._model.geom_contype[geom] = contype
        self._model.geom_conaffinity[geom] = conaffinity
        # MuJoCo looks at the body's masks first.
        self._model.body_contype[1 + thing] |= contype
        self._model.body_conaffinity[1 + thing] |= conaffinity
