"""Hides of arthropods: plates, jointed legs, antennae, claws and their many eyes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.hide.animal import CELLS
from pipeline.simulation.figures.hide.bristles import limb_bristles, trunk_bristles
from pipeline.simulation.figures.hide.coat import Coat
from pipeline.simulation.figures.hide.furrows import furrowed
from pipeline.simulation.figures.hide.lumps import Lump, budgeted
from pipeline.simulation.figures.hide.sheets import outward, painted, small_ball, tube
from pipeline.simulation.figures.hide.shell_parts import (
    LEG_STYLES,
    LegStyle,
    antenna_segment,
    beetle_leg,
    chelicerae,
    claw_solids,
    is_claw,
    joint_paint,
    leg_segment,
    mandibles,
    palps,
    sting_solid,
    venom_claws,
)
from pipeline.simulation.figures.hide.shells import beetle_plan, body_plates, front_of, shields
from pipeline.simulation.figures.hide.stance import Chain, Stance, smoothstep
from pipeline.simulation.figures.hide.wing_cases import pronotum, scutellum, wing_case
from pipeline.simulation.figures.link_shapes import EYE_MATERIAL
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, HORN, LEG, TAIL
from pipeline.simulation.figures.skins import Skin, merge_skins
from pipeline.simulation.figures.solids import Solid, join_solids
from pipeline.simulation.spatial import UP, Array, normalized

PLATE_TRIANGLES = {"body": 4000, HEAD: 800, TAIL: 1500}
"""Most triangles of the plates of a trunk, and of a head or abdomen of another material."""

BELOW_TRIANGLES = 1900
"""The same of a body whose upper plates are lofted."""

JAW_COLOR, EYE_COLOR = "#1c100a", "#060608"

UNDERSIDE_COLOR = "#0f0b08"

MANY_LEGS = 8
"""Legs beyond which each has fewer triangles."""

SPIDER_EYES = (
    *((0.62, 0.42, 0.24, 0.20), (0.50, 0.46, 0.60, 0.15)),
    *((0.26, 0.72, 0.30, 0.13), (0.16, 0.72, 0.66, 0.13)),
)
"""Eyes on one side of a spider's face: along, up, to the side and radius, in that of the face."""


SMALL_EYES = {
    "scorpion": ((-0.20, 0.62, 0.16, 0.13), (0.62, 0.44, 0.66, 0.07), (0.46, 0.48, 0.78, 0.07)),
    "centipede": ((0.70, 0.22, 0.74, 0.10), (0.54, 0.30, 0.86, 0.10), (0.58, 0.14, 0.88, 0.09)),
}
"""The same on one side of the head of those whose eyes are single."""

COMPOUND_EYES = {"ant": (0.30, 0.28, 0.16)}
"""Radii of compound eyes in that of the head: along, up and to the side."""

USUAL_COMPOUND_EYE = (0.46, 0.44, 0.30)


class ArthropodHide:
    """Builds the hide of one arthropod.

    Attributes:
        figure: an arthropod.
        stance: of the figure.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure, self.stance = figure, Stance(figure)
        self.kind = figure.skin.shell
        self.untouched: set[int] = set()
        self.coat = Coat(self.stance, None)

    def skins(self) -> tuple[dict[int, Skin], set[int]]:
        """Return the skins by link, and the links that are inside them."""
        found: dict[int, list[Skin]] = {0: []}
        covered = set[int]()
        trunk = list[int]()
        for i, limb in enumerate(self.figure.skeleton.limbs):
            chain = self.stance.chains[i]
            if any(self.figure.skeleton.links[n].shape != "round" for n in limb.links):
                continue
            if limb.kind == HEAD:
                trunk.append(i)
                covered.update(limb.links)
                if self.figure.jaws:
                    found[0] += self._jaws(chain)
            elif limb.kind == TAIL and self.kind != "scorpion":
                trunk.append(i)
                covered.update(limb.links)
            elif limb.kind in (LEG, ARM, FEELER, HORN, TAIL):
                self._add_limb(chain, found, covered)
        found[0] += self._stalks()
        found[0] += self._bare_front()
        found[0] += self._upper_plates()
        for link, lumps in self._plates().items():
            most = PLATE_TRIANGLES[self.figure.skeleton.links[link].kind]
            if self.kind in ("beetle", "centipede") and link == 0:
                most = BELOW_TRIANGLES
            found.setdefault(link, []).insert(0, self._meshed(lumps, most, trunk))
        return {link: merge_skins(skins) for link, skins in found.items()}, covered - set(found)

    def _meshed(self, lumps: list[Lump], most: int, trunk: list[int]) -> Skin:
        low = np.min([np.minimum(g.a, g.b) - g.reach for g in lumps], axis=0)
        high = np.max([np.maximum(g.a, g.b) + g.reach for g in lumps], axis=0)
        solid = budgeted(lumps, float((high - low).max()) / CELLS, most)
        paint = self.coat.paint(solid, trunk, False)
        if self.kind == "beetle":
            plan = beetle_plan(self.stance)
            # Dark below its upper plates.
            share = smoothstep((plan.front - solid.vertices[:, 0]) / (0.1 * plan.half_width))
            paint = painted(len(solid.vertices), UNDERSIDE_COLOR, 0.85 * share)
        # Dirt and shade lie in the creases between plates.
        paint = furrowed(paint, lumps, solid, self.coat.girth)
        return self.stance.hide(solid, trunk, paint, trunk_bristles(self.figure, solid))

    def _upper_plates(self) -> list[Skin]:
        """Return the lofted plates on the back of a beetle or a centipede."""
        plates: list[tuple[Solid, Array]] = []
        if self.kind == "beetle":
            plan = beetle_plan(self.stance)
            plates = [wing_case(plan, -1.0), wing_case(plan, 1.0), pronotum(plan), scutellum(plan)]
        elif self.kind == "centipede":
            plates = list(shields(self.stance))
        return [self.stance.rigid(solid, 0, paint) for solid, paint in plates]

    def _plates(self) -> dict[int, list[Lump]]:
        """Return the plates by the link whose part shows them: the body's where they can."""
        plates = body_plates(self.kind, self.stance)
        own = self.figure.pieces[0].material or self.figure.material
        found = {0: plates.pop("body")}
        for limb in self.figure.skeleton.limbs:
            lumps = plates.pop(limb.kind, [])
            if not lumps:
                continue
            last = limb.links[-1]
            material = self.figure.skeleton.links[last].material or self.figure.material
            found.setdefault(0 if material == own else last, []).extend(lumps)
        return found

    def _add_limb(self, chain: Chain, found: dict[int, list[Skin]], covered: set[int]) -> None:
        """Add the links of a limb, each rigid, to the first link of each run of one material."""
        limb = chain.limb
        links = self.figure.skeleton.links
        sign = -1.0 if limb.side == "l" else 1.0
        first = limb.links[0]
        claw = limb.kind != LEG and is_claw(chain)
        for i, number in enumerate(limb.links):
            if links[number].material != links[first].material:
                first = number
            solids = self._link_solids(chain, i, claw, sign)
            own = found.setdefault(first, [])
            for solid in solids:
                paint = joint_paint(chain, i, solid, self._leg_style)
                hair = limb_bristles(self.figure, solid, chain.ways[i])
                own.append(self.stance.rigid(solid, number, paint, hair))
            if number != first:
                covered.add(number)

    def _link_solids(self, chain: Chain, i: int, claw: bool, sign: float) -> list[Solid]:
        kind, last = chain.limb.kind, i == len(chain.ways) - 1
        if claw:
            if last:
                return claw_solids(chain, sign)
            return [leg_segment(chain, i, self._detail, self._leg_style)]
        if kind in (LEG, ARM):
            if self.kind == "beetle":
                solids = beetle_leg(chain, i)
            else:
                solids = [leg_segment(chain, i, self._detail, self._leg_style)]
            if i == 0 and self.kind != "beetle":
                r = min(float(chain.radii[0]), 1.5 * float(chain.radii[1]))
                solids.append(small_ball(chain.points[0], 0.95 * r))
            if last and self._leg_style.jointed:
                solids += _claws(chain)
            return solids
        if kind == TAIL:
            return [sting_solid(chain)] if last else [_tail_ring(chain, i)]
        return [antenna_segment(chain, i)]

    def _jaws(self, chain: Chain) -> list[Skin]:
        tip, along, r = chain.points[-1], chain.ways[-1], float(chain.radii[-1])
        if self.kind == "spider":
            solids = _fangs(tip, along, r)
        elif self.kind == "crab":
            solids = []
        elif self.kind == "scorpion":
            solids = chelicerae(tip, along, r)
        elif self.kind == "centipede":
            solids = venom_claws(tip, along, r)
        else:
            solids = mandibles(tip, along, r, 1.25)
            if self.kind == "beetle":
                solids += palps(tip, along, r)
        link = chain.limb.links[-1]
        return [
            self.stance.rigid(solid, link, painted(len(solid.vertices), JAW_COLOR, 0.9))
            for solid in solids
        ]

    def _bare_front(self) -> list[Skin]:
        """Return eyes and pincers of a scorpion whose drawing has no head: its shield has them."""
        if self.kind != "scorpion" or self._head is not None:
            return []
        tip, r = front_of(self.stance)
        skins = [
            self.stance.rigid(solid, 0, painted(len(solid.vertices), JAW_COLOR, 0.6))
            for solid in chelicerae(tip, np.array([1.0, 0.0, 0.0]), r)
        ]
        for side in (-1.0, 1.0):
            for solid in self._eye_solids(tip, r, side):
                skins.append(self.stance.rigid(solid, 0, painted(len(solid.vertices), EYE_COLOR)))
        return skins

    def _stalks(self) -> list[Skin]:
        if self.kind != "crab":
            return []
        solids = []
        for side in (-1.0, 1.0):
            root, end = self._stalk(side)
            curve = root + np.linspace(0.0, 1.0, 6)[:, None] * (end - root)
            r = self._head_radius
            solids.append(tube(curve, r * np.linspace(0.34, 0.24, 6), 8))
        return [self.stance.rigid(solid, self._head_link) for solid in solids]

    @property
    def _leg_style(self) -> LegStyle:
        return LEG_STYLES.get(self.kind, LegStyle())

    @property
    def _detail(self) -> float:
        return 1.0 if len(self.figure.skeleton.legs) <= MANY_LEGS else 0.55

    @property
    def _head(self) -> Chain | None:
        return next((c for c in self.stance.chains if c.limb.kind == HEAD), None)

    @property
    def _head_link(self) -> int:
        head = self._head
        return head.limb.links[-1] if head is not None else 0

    @property
    def _head_radius(self) -> float:
        head = self._head
        return float(head.radii[-1]) if head is not None else 0.1

    def _stalk(self, side: float) -> tuple[Array, Array]:
        head = self._head
        assert head is not None
        r = self._head_radius
        root = head.points[-1] + r * np.array([0.15, 0.2, 0.65 * side])
        return root, root + r * np.array([0.55, 1.25, 0.35 * side])

    def eyes(self) -> Iterator[tuple[int, Skin]]:
        """Yield the numbers of the pieces of the eyes, and their skins."""
        head = self._head
        if head is None:
            return
        link, r, tip = head.limb.links[-1], self._head_radius, head.points[-1]
        for number, piece in enumerate(self.figure.pieces):
            if piece.material != EYE_MATERIAL or piece.link != link:
                continue
            side = -1.0 if piece.name.endswith("_l") else 1.0
            solid = join_solids(list(self._eye_solids(tip, r, side)))
            yield number, self.stance.rigid(solid, link)

    def _eye_solids(self, tip: Array, r: float, side: float) -> Iterator[Solid]:
        scale = self.figure.skin.eye_size
        if self.kind == "spider":
            for x, y, z, size in SPIDER_EYES:
                yield small_ball(tip + r * np.array([x, y, side * z]), size * r * scale)
            return
        if self.kind == "crab":
            yield small_ball(self._stalk(side)[1], 0.42 * r * scale)
            return
        if self.kind in SMALL_EYES:
            for x, y, z, size in SMALL_EYES[self.kind]:
                yield small_ball(tip + r * np.array([x, y, side * z]), size * r * scale)
            return
        # Compound eyes: large, drawn out along the side of the head.
        unit = small_ball(np.zeros(3), 1.0, 12, 9)
        sizes = r * scale * np.array(COMPOUND_EYES.get(self.kind, USUAL_COMPOUND_EYE))
        at = tip + r * np.array([0.50, 0.30, side * 0.80])
        yield outward(Solid(at + sizes * unit.vertices, unit.faces))


def _claws(chain: Chain) -> Iterator[Solid]:
    """Yield the two claws of a foot."""
    tip, r = chain.points[-1], float(chain.radii[-1])
    out = normalized(chain.ways[-1] * [1.0, 0.35, 1.0])
    side = normalized(np.cross(out, UP))
    for sign in (-1.0, 1.0):
        way = normalized(out + 0.55 * sign * side)
        curve = np.array(
            [tip, tip + 1.6 * r * way + 0.2 * r * UP, tip + 3.2 * r * way - 0.7 * r * UP]
        )
        yield tube(curve, r * np.array([0.7, 0.45, 0.08]), 5)


def _fangs(tip: Array, along: Array, r: float) -> list[Solid]:
    """Return the chelicerae and palps of a spider."""
    side = np.array([0.0, 0.0, 1.0])
    solids = []
    for sign in (-1.0, 1.0):
        root = tip + r * (0.45 * along - 0.15 * UP + 0.36 * sign * side)
        curve = np.array(
            [root, root + r * (0.62 * along - 0.42 * UP), root + r * (0.66 * along - 1.05 * UP)]
        )
        solids.append(tube(curve, r * np.array([0.34, 0.36, 0.22]), 9))
        fang = curve[-1]
        bent = np.array(
            [fang, fang + r * (0.1 * along - 0.3 * UP), fang - r * (0.12 * along + 0.55 * UP)]
        )
        solids.append(tube(bent, r * np.array([0.17, 0.12, 0.02]), 6))
        palp = tip + r * (0.30 * along - 0.2 * UP + 0.72 * sign * side)
        line = np.array(
            [
                palp,
                palp + r * (0.9 * along + 0.35 * UP + 0.25 * sign * side),
                palp + r * (1.75 * along - 0.25 * UP + 0.1 * sign * side),
            ]
        )
        solids.append(tube(line, r * np.array([0.20, 0.20, 0.24]), 8))
    return solids


def _tail_ring(chain: Chain, i: int) -> Solid:
    """Return one ring of a scorpion's tail, with edges and narrow joints."""
    a, b = chain.points[i], chain.points[i + 1]
    r_a, r_b = float(chain.radii[i]), float(chain.radii[i + 1])
    r_a = min(r_a, 1.3 * r_b)
    t = np.linspace(0.0, 1.0, 10)
    shape = np.interp(t, [0.0, 0.08, 0.25, 0.85, 0.96, 1.0], [0.55, 0.80, 0.98, 1.12, 0.95, 0.60])
    return tube(a + t[:, None] * (b - a), (r_a + (r_b - r_a) * t) * shape, 10)
