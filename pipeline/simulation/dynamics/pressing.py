"""Pressing: MuJoCo calls the impact law between finding and solving contacts."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.impact_law import (
    NOW,
    PAIR,
    STRIKE,
    THING,
    Law,
    Touching,
    press,
)
from pipeline.simulation.dynamics.native import Layout, array_at, layout_of, native

STRIKES, STRIKES_A_BODY = 4096, 256
"""Room for the strikes of one step; a pair that bounces strikes again some sub-steps later."""

SLOTS = ("now", "things", "pairs", "speeds", "strikes", "velocity", "centre", "attitude", "owners")

AT = np.dtype([(name, "i8") for name in (*SLOTS, "kinds", "room", "told", "geoms")])
"""Addresses of what the law works with, number of things, room for contacts and strikes,
number of geoms."""

NUMBER, WHOLE = np.dtype("f8"), np.dtype("i4")


class Pressing:
    """The law of one world.

    Args:
        things: (m,) what is known of them.
        bodies: how many of them are.
        uneven: whether the ground is a height field.
        model: of MuJoCo.
        data: its state; has room for one number of ours.
        mujoco: the module.

    Attributes:
        h: (1,) length of a sub-step [s].
        told: (1,) how many strikes are kept.
        strikes: `STRIKE`, the bounces that began.
        callback: what MuJoCo is to call.
    """

    def __init__(
        self, things: Records, bodies: int, uneven: bool, model: Any, data: Any, mujoco: Any
    ) -> None:
        now = np.zeros(1, dtype=NOW)
        now["uneven"], now["bodies"] = uneven, bodies
        self.strikes = np.zeros(STRIKES + STRIKES_A_BODY * len(things), dtype=STRIKE)
        # Names of records cost more than the rest of a step of one body.
        self.h, self.told = now["h"], now["told"]
        layout = layout_of(mujoco)
        room = data.narena // layout.contact.itemsize
        # Memory that is asked for is taken up where it is used.
        arrays = (now, things, np.zeros(2 * room, dtype=PAIR), np.zeros(room), self.strikes)
        fixed = (data.cvel, data.xipos, data.xmat, model.geom_bodyid)
        counts = (len(things), room, len(self.strikes), model.ngeom)
        at = np.array([(*(a.ctypes.data for a in (*arrays, *fixed)), *counts)], dtype=AT)
        data.userdata.view(np.int64)[0] = at.ctypes.data
        self._held = (*arrays, *fixed, at)
        self.callback = _callback(layout)


@cache
def _callback(layout: Layout) -> Any:
    """Return what MuJoCo calls, which finds its world by the number that its data hold."""
    data_kind, contact_kind = layout

    def push(_: int, address: int) -> None:
        data = array_at(address, 1, data_kind)[0]
        where = array_at(data.userdata, 1, NUMBER).view(np.int64)[0]
        # MuJoCo forgets all when it begins anew, after what is no number.
        if where == 0:
            return
        at = array_at(where, 1, AT)[0]
        now = array_at(at.now, 1, NOW)[0]
        if data.ncon == 0:
            now.known = 0
            return
        touching = Touching(
            array_at(data.contact, data.ncon, contact_kind),
            array_at(at.owners, at.geoms, WHOLE),
            array_at(data.efc_KBIP, 4 * data.nefc, NUMBER).reshape(-1, 4),
            array_at(data.efc_pos, data.nefc, NUMBER),
            array_at(at.velocity, 6 * at.kinds, NUMBER).reshape(-1, 6),
            array_at(at.centre, 3 * at.kinds, NUMBER).reshape(-1, 3),
            array_at(at.attitude, 9 * at.kinds, NUMBER).reshape(-1, 9),
        )
        law = Law(
            now,
            things=array_at(at.things, at.kinds, THING),
            pairs=array_at(at.pairs, 2 * at.room, PAIR).reshape(2, -1),
            speeds=array_at(at.speeds, at.room, NUMBER),
            strikes=array_at(at.strikes, at.told, STRIKE),
        )
        press(touching, law, data.time)

    made = native(push)
    if made is push:
        # Not compiled: MuJoCo calls it with its objects.
        return lambda model, data: push(model._address, data._address)
    return made
