"""Bends: joints that squeak when they bend and squawk when they jerk.

What is heard is a limb, as loud as the quickest of its joints: a joint's two surfaces rub at
its rate times its radius. A joint that slides rubs as fast as it slides.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

import math

import numpy as np

from audio.acoustic_materials import family_name
from pipeline.simulation.detect.hearing import event_of_spell, fits
from pipeline.simulation.detect.scenery import Scenery, Seen, Solid
from pipeline.simulation.detect.spells import Spell, Spells
from pipeline.simulation.spatial import Array, unturn
from pipeline.simulation.take import SoundEvent
from pipeline.spec.detect import Bending, Detect


class Bends:
    """Joints that are heard, limb by limb.

    Args:
        scenery: who there is.
        words: the author's, of one cause.
        cause: its name.
        most: rate at which it becomes another sound [rad/s].
    """

    def __init__(
        self, scenery: Scenery, words: Bending, cause: str, most: float = math.inf
    ) -> None:
        self.scenery, self.cause = scenery, cause
        self._solids = [s for s in scenery.solids.values() if _bends(scenery, s, words)]
        self.idle = not self._solids
        limbs: dict[str, list[int]] = {}
        for i, solid in enumerate(self._solids):
            limbs.setdefault(_limb(scenery.nodes[solid.node].name), []).append(i)
        self._limbs = list(limbs.values())
        self._nodes = np.array([s.node for s in self._solids], dtype=np.int64)
        self._parents = np.array([scenery.nodes[n].parent for n in self._nodes], dtype=np.int64)
        self._radius = np.array([0.5 * s.thickness for s in self._solids])
        self._factor = np.array([words.materials[_family(s)] for s in self._solids])
        upper, lower = math.radians(words.above_deg_s), math.radians(words.ends_deg_s)
        ones = np.ones(len(self._limbs))
        self._spells = Spells(lower * ones, upper * ones, words, scenery.dt)
        self._most = most

    def look(self, seen: Seen) -> list[SoundEvent]:
        """See `Watch`."""
        rate = self._rates(seen)
        rub = rate * self._radius
        level = rate / self._factor
        p = seen.p[seen.told][:, self._nodes]
        levels, values = list[Array](), list[Array]()
        for joints in self._limbs:
            quickest = level[:, joints].argmax(axis=1)
            rows, of = np.arange(len(level)), np.array(joints)[quickest]
            levels.append(level[rows, of])
            joint = of[:, None].astype(float)
            values.append(np.concatenate([rub[rows, of, None], p[rows, of], joint], axis=1))
        first = seen.first + seen.told.start
        spells = self._spells.look(
            first, np.stack(levels, axis=1), np.stack(values, axis=1), seen.final
        )
        return [self._event(spell) for spell in spells if spell.top <= self._most]

    def _event(self, spell: Spell) -> SoundEvent:
        """Return the sound of a limb, which has the name of the joint that rubs most."""
        loudest = max(spell.values, key=lambda row: row[0])
        of = Spell(
            *(spell.thing, spell.begin, spell.first, spell.last, spell.top),
            [row[:4] for row in spell.values],
        )
        solid = self._solids[int(loudest[4])]
        return event_of_spell(of, self.cause, solid, self.scenery.clock)

    def _rates(self, seen: Seen) -> Array:
        """Return how fast joints bend at the rows told (m, N) [rad/s]."""
        R_WP, R_WC = seen.R[:, self._parents], seen.R[:, self._nodes]
        R_PC = np.swapaxes(R_WP, -1, -2) @ R_WC
        p_PC = unturn(R_WP, seen.p[:, self._nodes] - seen.p[:, self._parents])
        turned, moved = R_PC[1:] - R_PC[:-1], p_PC[1:] - p_PC[:-1]
        # Of two rotations θ apart the difference has a Frobenius norm of 2√2 sin(θ / 2).
        chord = np.sqrt((turned * turned).sum(axis=(-1, -2)))
        angle = 2.0 * np.arcsin(np.minimum(chord / math.sqrt(8.0), 1.0))
        slid = np.sqrt((moved * moved).sum(axis=-1)) / self._radius
        alive = seen.alive[1:, self._nodes] & seen.alive[:-1, self._nodes]
        return seen.by_row(alive * (angle + slid) / self.scenery.dt)


class Squeaks(Bends):
    """Joints that bend, but do not squawk."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        most = detect.squawk.above_deg_s if detect.squawk.heard else math.inf
        super().__init__(scenery, detect.squeak, "squeak", math.radians(most))


class Squawks(Bends):
    """Joints that jerk."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        super().__init__(scenery, detect.squawk, "squawk")


def _bends(scenery: Scenery, solid: Solid, words: Bending) -> bool:
    node = scenery.nodes[solid.node]
    own = node.parent >= 0 and scenery.nodes[node.parent].performer == node.performer
    return own and fits(node.performer, words.who) and _family(solid) in words.materials


def _family(solid: Solid) -> str:
    return family_name(solid.material)


def _limb(name: str) -> str:
    """Return the name of the limb that a link is of, such as "bug.l1" of "bug.l1.2"."""
    limb, _, link = name.rpartition(".")
    return limb if link.isdecimal() else name
