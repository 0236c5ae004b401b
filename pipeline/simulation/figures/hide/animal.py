"""Hides of animals: one grown-together surface of what has one material, meshed as it stands.

Trunk, neck, limbs and tail are lumps of one coarse mesh. Skull and paws are meshed finer, together
with a piece of what they grow from, whose surface is the same in both: no seam is seen. What is
made of another material, such as hooves, horns and hair, is a surface of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.hide.coat import Coat
from pipeline.simulation.figures.hide.eyes import eyeball, eyelids
from pipeline.simulation.figures.hide.feet import (
    foot_way,
    hand_lumps,
    paw_claws,
    paw_lumps,
    sole_lump,
    spread_toes,
    toe_nails,
)
from pipeline.simulation.figures.hide.fillets import filleted
from pipeline.simulation.figures.hide.furrows import furrowed
from pipeline.simulation.figures.hide.hair_lay import HairLay
from pipeline.simulation.figures.hide.head import Head
from pipeline.simulation.figures.hide.head_gear import (
    beak_solid,
    ear_solid,
    horn_solid,
    lip_groove,
    mouth_solid,
    nose_solid,
    proboscis_solid,
    whisker_solids,
)
from pipeline.simulation.figures.hide.lumps import Lump, ball, budgeted
from pipeline.simulation.figures.hide.mane import hair_solid, mane_solid, tassel_lumps
from pipeline.simulation.figures.hide.shanks import (
    above_shank,
    ankle_lump,
    first_shank,
    shank_solid,
    tail_solid,
)
from pipeline.simulation.figures.hide.sheets import Paint, hoof, lay, painted
from pipeline.simulation.figures.hide.skulls import DEFAULT_SKULLS, SKULLS
from pipeline.simulation.figures.hide.stance import Chain, Stance, smoothstep
from pipeline.simulation.figures.hide.trunk import (
    body_lumps,
    has_muscles,
    haunch_lumps,
    leg_lumps,
    tube_lumps,
)
from pipeline.simulation.figures.link_shapes import EYE_MATERIAL
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, HORN, LEG, TAIL, WING
from pipeline.simulation.figures.skins import Skin, merge_skins
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import Array, rotation

MAIN_TRIANGLES, FINE_TRIANGLES, FOOT_TRIANGLES = 3200, 2300, 320
"""Most triangles of the coarse mesh, of a skull, and of a paw."""


NECKLESS = 0.9
"""Radius of a head on spread legs from which it grows together with the trunk, in the trunk's."""

NECKLESS_TRIANGLES = 2500
"""Triangles that such a head adds to the coarse mesh, whose legs it makes finer, too."""

COLUMN_TRIANGLES = 600
"""Triangles that a stout leg adds to the coarse mesh."""

TASSEL_CELL, TASSEL_TRIANGLES = 0.5, 300
"""Cell of the tuft or the bush of a tail, in its radius, and its most triangles."""

PAW_SHANK = 0.86
"""Radius of a shank above a paw, in that drawn, which holds its coat as well."""

SLEEK_TRIANGLES = 650
"""Triangles that the muscles below a sleek coat add to the coarse mesh: no hair hides them."""

MUSCLED_CORE = 0.50
"""Radius of the root of a leg below the muscles of shoulder and haunch, in that drawn."""

LIMB_TRIANGLES = 1000
"""Most triangles of the coarse mesh of a limb that has a material of its own."""

NET_CELL = 0.55
"""Cell of a coarse mesh with a net of patches, in the usual one: thin lines need more vertices."""

CELLS = 96
"""Cells of the coarse mesh along the longest side of an animal, at first."""

HEAD_CELL, FOOT_CELL = 0.11, 0.24
"""Cell of a skull and of a paw, in the radius there, at first."""

FURROW_GIRTH = 0.6
"""Radius of a skull or a paw for its furrows, in that of its lumps: they are finer."""

DEFAULT_TOES = {"hooves": 1, "paws": 4, "toes": 4, "claws": 5, "plain": 0}
"""Toes of a foot that says no number."""

DARK_HORN = "#2b231d"

MOUTH_COLOR, WHISKER_COLOR = "#150c0a", "#d9d4cc"

SIDEWAYS = np.array([0.0, 0.0, 1.0])


@dataclass(eq=False)
class Patch:
    """Surfaces of one part of the take.

    Attributes:
        limbs: numbers of the limbs that it follows.
        lumps: of its coarse mesh.
        fine: lumps of finer meshes, their cell [m], their most triangles, and whether a skull's.
        shanks: surfaces that grow out of the coarse mesh, and the number of the limb of each.
        skins: more surfaces.
        covered: links inside.
        most: triangles of its coarse mesh beyond the usual.
        has_face: whether the skull is part of its coarse mesh.
    """

    limbs: list[int] = field(default_factory=list)
    lumps: list[Lump] = field(default_factory=list)
    fine: list[tuple[list[Lump], float, int, bool]] = field(default_factory=list)
    shanks: list[tuple[Solid, int]] = field(default_factory=list)
    skins: list[Skin] = field(default_factory=list)
    covered: set[int] = field(default_factory=set)
    most: int = 0
    has_face: bool = False


class AnimalHide:
    """Builds the hide of one figure.

    Attributes:
        figure: an animal.
        stance: of the figure.
        patches: by number of the link whose part shows them; 0 is the body.
        colored: lumps with a colour of their own.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure, self.stance = figure, Stance(figure)
        self.patches: dict[int, Patch] = {0: Patch()}
        self.untouched: set[int] = set()
        self.colored: list[tuple[Lump, str]] = []
        skeleton = figure.skeleton
        self.head_limb = next(
            (i for i, limb in enumerate(skeleton.limbs) if limb.kind == HEAD), None
        )
        self.head: Head | None = None
        if self.head_limb is not None:
            name = figure.skin.skull or DEFAULT_SKULLS[figure.feet]
            self.head = Head.of(self.stance.chains[self.head_limb], SKULLS[name], figure.skin)
        self.skull_name = figure.skin.skull or DEFAULT_SKULLS[figure.feet]
        self.coat = Coat(self.stance, self.head)
        self.hair_lay = HairLay(self.coat)

    def skins(self) -> tuple[dict[int, Skin], set[int]]:
        """Return the skins by link, and the links that are inside them."""
        figure = self.figure
        body = self.patches[0]
        trunk = list(body_lumps(figure, self._leg_core))
        body.lumps += [*trunk, *self._haunches(trunk)]
        is_patched = any(paint.where == "patches" for paint in figure.skin.paint)
        if figure.feet == "hooves" and has_muscles(self.stance) and not is_patched:
            body.most += SLEEK_TRIANGLES
        for i, limb in enumerate(figure.skeleton.limbs):
            if any(figure.skeleton.links[n].shape != "round" for n in limb.links):
                self.untouched.update(limb.links)
            elif limb.kind in (LEG, ARM):
                self._add_leg(i)
            elif limb.kind == HEAD:
                self._add_head(i)
            elif limb.kind == TAIL:
                self._add_tail(i)
            elif limb.kind == WING or self.head is None:
                self.untouched.update(limb.links)
            else:
                self._add_twig(i)
        self._add_lumps()
        found = {}
        covered = set[int]()
        for link, patch in self.patches.items():
            made = list(self._meshes(patch))
            if made:
                found[link] = merge_skins(made)
            covered |= patch.covered
        return found, covered - set(found)

    @cached_property
    def _is_neckless(self) -> bool:
        """Whether it is squat, as a frog, and its head grows together with its trunk."""
        is_spread = self.figure.style != "mammal"
        broad = NECKLESS * self.coat.girth
        return is_spread and self.head is not None and max(self.head.radii) > broad

    def _haunches(self, trunk: Sequence[Lump]) -> Iterator[Lump]:
        # Spread legs have no shoulders that stand out.
        return haunch_lumps(self.stance, trunk) if self.figure.style == "mammal" else iter(())

    @cached_property
    def _material(self) -> str:
        return self._resolved(self.figure.pieces[0].material)

    def _resolved(self, material: str) -> str:
        return material or self.figure.material

    def _patch(self, link: int) -> Patch:
        """Return the patch of a link: the body's where they are of one material."""
        own = self._resolved(self.figure.skeleton.links[link].material)
        key = 0 if own == self._material else link
        return self.patches.setdefault(key, Patch())

    def _runs(self, links: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield the first and the last but one of each run of links of one material."""
        materials = [self._resolved(self.figure.skeleton.links[n].material) for n in links]
        first = 0
        for k in range(1, len(links) + 1):
            if k == len(links) or materials[k] != materials[first]:
                yield first, k
                first = k

    # --- legs and arms ---

    def _add_leg(self, i: int) -> None:
        limb, chain = self.figure.skeleton.limbs[i], self.stance.chains[i]
        girths = self._girths(i)
        feet = self.figure.feet if limb.kind == LEG else self._hand()
        runs = list(self._runs(limb.links))
        # A hoof of horn, toes and soles end a leg whose coat goes down to them.
        if len(runs) > 1 and runs[-1][1] - runs[-1][0] == 1:
            runs = [*runs[:-2], (runs[-2][0], runs[-1][1])]
        for first, after in runs:
            patch = self._patch(limb.links[first])
            patch.limbs.append(i)
            patch.covered.update(limb.links[first:after])
            shank = min(max(first, first_shank(limb)), after)
            if feet == "plain" or self._is_neckless:
                # A column or a leg of a squat animal is thick enough for the grid of the trunk.
                lumps = list(leg_lumps(chain, first, after, girths))
                patch.lumps += lumps
                patch.most += COLUMN_TRIANGLES
            elif shank == after or after < len(limb.links) or first >= first_shank(limb):
                lumps = list(leg_lumps(chain, first, after, girths))
                patch.lumps += lumps
            else:
                patch.lumps += leg_lumps(
                    chain, first, shank, girths, above_shank(feet), self._leg_core
                )
                lumps = [ankle_lump(chain)]
                patch.shanks.append((shank_solid(chain, shank, girths, feet), i))
            if after == len(limb.links):
                self._add_foot(chain, feet, patch, lumps, girths[-1])

    @property
    def _leg_core(self) -> float:
        """Radius of a leg at its root, in that drawn."""
        return MUSCLED_CORE if has_muscles(self.stance) else 1.0

    def _girths(self, i: int) -> Array:
        """Return width and depth (n + 1, 2) of a limb at its nodes, in the drawn radii."""
        nodes = list(self.figure.anatomy.appendages[i].nodes)
        girths = self.figure.drawing.girths[nodes, :2].copy()
        # The girth of a body's node is the body's.
        girths[0] = 1.0
        has_paws = self.figure.feet == "paws" and self.figure.skin.toes != 2
        if has_paws and self.figure.skeleton.limbs[i].kind == LEG:
            girths[2:-1] *= PAW_SHANK
        return girths

    def _hand(self) -> str:
        return "paws" if self.figure.feet in ("paws", "hooves") else self.figure.feet

    def _add_foot(
        self, chain: Chain, feet: str, patch: Patch, lumps: list[Lump], girths: Array
    ) -> None:
        limb = chain.limb
        last = limb.links[-1]
        own = self._resolved(self.figure.skeleton.links[last].material)
        # The word counts toes; hands have the usual fingers.
        toes = (limb.kind == LEG and self.figure.skin.toes) or DEFAULT_TOES[feet]
        radius = float(chain.radii[-1])
        target = patch
        differs = own != self._resolved(self.figure.skeleton.links[limb.links[0]].material)
        if feet == "hooves":
            ahead, way = foot_way(chain), chain.ways[-1]
            slope = float(way @ ahead) / max(-float(way[1]), 0.1)
            solid = hoof(chain.points[-1], ahead, slope, radius, min(toes, 2))
            if differs:
                target = self.patches.setdefault(last, Patch())
            paint = None if differs else painted(len(solid.vertices), DARK_HORN)
            target.skins.append(self.stance.rigid(solid, last, paint))
        elif feet == "paws":
            has_claws = self.figure.skin.claws
            flesh = (
                hand_lumps(chain, toes, girths)
                if limb.kind == ARM
                else paw_lumps(chain, toes, girths, has_claws)
            )
            patch.fine.append(([*lumps[-1:], *flesh], FOOT_CELL * radius, FOOT_TRIANGLES, False))
            for solid in paw_claws(chain, toes, girths) if has_claws and limb.kind == LEG else ():
                paint = painted(len(solid.vertices), DARK_HORN)
                patch.skins.append(self.stance.rigid(solid, last, paint))
        elif feet == "plain":
            patch.lumps.append(sole_lump(chain))
            for solid in toe_nails(chain, toes):
                paint = painted(len(solid.vertices), "#b3a68f")
                patch.skins.append(self.stance.rigid(solid, last, paint))
        elif feet in ("toes", "claws"):
            for toe, claw in spread_toes(chain, toes, self.figure.skin.claws):
                patch.skins.append(self.stance.rigid(toe, last))
                if claw is None:
                    continue
                paint = painted(len(claw.vertices), DARK_HORN)
                patch.skins.append(self.stance.rigid(claw, last, paint))

    # --- head, neck and tail ---

    def _add_head(self, i: int) -> None:
        limb, chain = self.figure.skeleton.limbs[i], self.stance.chains[i]
        if i != self.head_limb or self.head is None:
            self.untouched.update(limb.links)
            return
        necks = limb.links[:-1]
        stub: list[Lump] = []
        for first, after in self._runs(necks):
            patch = self._patch(necks[first])
            patch.limbs.append(i)
            patch.covered.update(necks[first:after])
            points, radii = chain.points[first : after + 1], chain.radii[first : after + 1]
            deep, wide = self._neck_shape(first)
            nodes = self.figure.anatomy.appendages[i].nodes[first : after + 1]
            heights = self.figure.drawing.girths[list(nodes), 1].copy()
            if first == 0:
                heights[0] = 1.0
            blend = 0.9 if first == 0 else 0.3
            stub = list(tube_lumps(points, radii, deep, wide, blend, heights))
            patch.lumps += stub
        last = limb.links[-1]
        is_bird = self.skull_name == "bird" and bool(necks)
        # A head has the coat of its neck, whatever its tip is made of.
        bearer = self._patch(necks[-1] if necks else last)
        if i not in bearer.limbs:
            bearer.limbs.append(i)
        bearer.covered.add(last)
        radius = max(self.head.radii)
        if self._is_neckless:
            # A head as broad as the trunk grows together with it.
            bearer.lumps += self.head.lumps()
            bearer.most += NECKLESS_TRIANGLES
            bearer.has_face = True
        else:
            lumps = [*stub[-2:], *self.head.lumps()]
            bearer.fine.append((lumps, HEAD_CELL * radius, FINE_TRIANGLES, True))
        self._add_features(bearer, last)
        if is_bird:
            patch = self.patches.setdefault(last, Patch())
            patch.skins.append(self.stance.rigid(beak_solid(self.head), last))
        if self.figure.skin.mane != "none" and necks:
            on_neck = list(self.figure.anatomy.appendages[i].nodes[:-1])
            heights = self.figure.drawing.girths[on_neck, 1]
            solid = mane_solid(chain, self.figure.skin.mane, self.head, heights)
            color = next((p.color for p in self.figure.skin.paint if p.where == "mane"), "#17120f")
            paint, locks = painted(len(solid.vertices), color), self.hair_lay.locks(solid, i)
            self.patches[0].skins.append(self.stance.hide(solid, [i], paint, locks))

    def _add_features(self, patch: Patch, skull_link: int) -> None:
        """Add lids, mouth and whiskers, which are finer than the mesh of a skull."""
        head = self.head
        assert head is not None
        features: list[tuple[Solid, Paint]] = []
        for side in (1.0, -1.0) if head.skull.lids else ():
            solid, rim = eyelids(head, side)
            paint = self.coat.paint(solid, patch.limbs, True)
            assert paint is not None
            lay(paint, head.skull.lid_color, rim)
            features.append((solid, paint))
        for line in (mouth_solid(head), lip_groove(head)):
            if line is not None:
                features.append((line, painted(len(line.vertices), MOUTH_COLOR)))
        nose = nose_solid(head)
        if nose is not None:
            features.append(nose)
        for solid in whisker_solids(head):
            features.append((solid, painted(len(solid.vertices), WHISKER_COLOR)))
        patch.skins += [self.stance.rigid(solid, skull_link, paint) for solid, paint in features]

    def _neck_shape(self, first: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return height and width of a neck at its ends, in the drawn radius."""
        if self.skull_name == "bird":
            return (1.0, 1.0), (1.0, 1.0)
        return ((1.08, 1.0), (0.74, 0.80)) if first == 0 else ((1.0, 1.0), (0.78, 0.80))

    def _add_tail(self, i: int) -> None:
        limb, chain = self.figure.skeleton.limbs[i], self.stance.chains[i]
        word = self.figure.skin.tail
        patch = self._patch(limb.links[0])
        patch.limbs.append(i)
        patch.covered.update(limb.links)
        girths = self._girths(i).mean(axis=-1)
        if word in ("hair", "fan"):
            own = self._patch(limb.links[-1])
            if i not in own.limbs:
                own.limbs.append(i)
            solid = hair_solid(chain, word, self.stance.ground)
            paint, locks = self.coat.paint(solid, [i], False), self.hair_lay.locks(solid, i)
            own.skins.append(self.stance.hide(solid, [i], paint, locks))
            return
        shape = (1.0, 1.0), (1.0, 1.0)
        for first, after in self._runs(limb.links):
            own = self._patch(limb.links[first])
            if i not in own.limbs:
                own.limbs.append(i)
            own.covered.update(limb.links[first:after])
            points, radii = chain.points[first : after + 1], chain.radii[first : after + 1].copy()
            radii *= girths[first : after + 1]
            if first == 0 and len(radii) > 1:
                radii[0] = min(radii[0], 2.2 * radii[1])
            if first == 0:
                own.lumps += tube_lumps(points[:2], radii[:2], *shape, 0.6)
            # Beyond its root a tail is too thin for the grid of the trunk.
            beyond = (self.figure.skin.tail_length - 1.0) * limb.length
            if after < len(limb.links) or word != "plain":
                beyond = 0.0
            solid = tail_solid(points, radii, 0.4 if first == 0 else 0.0, max(beyond, 0.0))
            own.skins.append(self._hide(solid, [i]))
            if word in ("tassel", "brush") and after == len(limb.links):
                # By itself: it would grow together with legs that it hangs beside.
                cell = TASSEL_CELL * float(chain.radii[1:].max())
                tuft = budgeted(list(tassel_lumps(chain, word)), cell, TASSEL_TRIANGLES)
                own.skins.append(self._hide(tuft, [i]))

    # --- ears and horns ---

    def _add_twig(self, i: int) -> None:
        limb, chain = self.figure.skeleton.limbs[i], self.stance.chains[i]
        head = self.head
        assert head is not None
        assert self.head_limb is not None
        skull_link = self.figure.skeleton.limbs[self.head_limb].links[-1]
        on_head = min(
            float(np.linalg.norm(chain.points[0] - p))
            for p in self.stance.chains[self.head_limb].points[1:]
        )
        side = float(np.sign(chain.points[-1][2])) if limb.side != "m" else 0.0
        if on_head > 1e-6 * limb.length or (side == 0.0 and limb.kind != FEELER):
            self.untouched.update(limb.links)
            return
        if side == 0.0:
            solid, folds = proboscis_solid(chain)
            patch = self._patch(limb.links[0])
            patch.covered.update(limb.links)
            patch.skins.append(self.stance.chained(solid, chain, skull_link, folds))
            return
        material = self.figure.skeleton.links[limb.links[-1]].material
        patch = self.patches.setdefault(limb.links[0], Patch())
        patch.covered.update(limb.links)
        hair: Array | None = None
        if limb.kind == HORN or "horn" in material or "bone" in material or "ivory" in material:
            solid = horn_solid(head, chain, side, self.figure.skin.horns)
            paint = None if material else painted(len(solid.vertices), DARK_HORN)
        else:
            solid, inner = ear_solid(head, chain, side, self.figure.skin)
            color = next((p.color for p in self.figure.skin.paint if p.where == "ears"), "#7a5548")
            paint = np.zeros((len(solid.vertices), 4))
            # Their backs have the coat of the face.
            for layer in self.figure.skin.paint:
                if layer.where == "face":
                    lay(paint, layer.color, np.full(len(paint), layer.share))
            lay(paint, color, 0.75 * inner)
            hair = self.hair_lay.ear(solid, inner)
        patch.skins.append(self.stance.rigid(solid, skull_link, paint, hair))

    def _add_lumps(self) -> None:
        """Add the flesh that the figure's words ask for."""
        figure = self.figure
        names = figure.drawing.names
        radii = figure.drawing.radii * figure.scale
        placed = {n: figure.points[n] for n in figure.anatomy.body}
        bearer: dict[int, Patch] = dict.fromkeys(placed, self.patches[0])
        for chain, appendage in zip(self.stance.chains, figure.anatomy.appendages, strict=True):
            for k, (node, point) in enumerate(zip(appendage.nodes, chain.points, strict=True)):
                placed.setdefault(node, point)
                bearer.setdefault(node, self._patch(chain.limb.links[max(k - 1, 0)]))
        on_skull = (
            () if self.head_limb is None else figure.anatomy.appendages[self.head_limb].nodes[-2:]
        )
        for word in figure.skin.lumps:
            node = names.index(word.node)
            r = float(radii[node])
            turn = rotation(SIDEWAYS, np.radians(word.turn_deg))
            axes = np.eye(3) @ turn.T
            at, radii_of = placed[node] + r * np.array(word.at), [r * v for v in word.radii]
            lump = ball(at, radii_of, word.blend * r, axes, word.carve)
            lumps = [lump, lump.mirrored()] if word.mirror else [lump]
            bearer[node].lumps += lumps
            if word.color is not None:
                self.colored += [(lump, word.color) for lump in lumps]
            if node in on_skull:
                for fine in bearer[node].fine:
                    if fine[3]:
                        fine[0].extend(lumps)

    # --- surfaces ---

    def _meshes(self, patch: Patch) -> Iterator[Skin]:
        if patch.lumps:
            low = np.min([np.minimum(g.a, g.b) - g.reach for g in patch.lumps], axis=0)
            high = np.max([np.maximum(g.a, g.b) + g.reach for g in patch.lumps], axis=0)
            cell = float((high - low).max()) / CELLS
            most = MAIN_TRIANGLES if patch is self.patches[0] else LIMB_TRIANGLES
            most += patch.most
            if any(paint.where == "patches" for paint in self.figure.skin.paint):
                cell, most = NET_CELL * cell, int(most / NET_CELL**2)
            solid = budgeted(patch.lumps, cell, most)
            for shank, i in patch.shanks:
                solid, shank = filleted(solid, patch.lumps, shank)
                yield self._hide(shank, [i])
            yield self._hide(solid, patch.limbs, has_face=patch.has_face, lumps=patch.lumps)
        for lumps, cell, most, is_head in patch.fine:
            yield self._meshed(patch, lumps, cell, most, is_head)
        yield from patch.skins

    def _meshed(
        self, patch: Patch, lumps: list[Lump], cell: float, most: int, is_head: bool
    ) -> Skin:
        solid = budgeted(lumps, cell, most)
        girth = FURROW_GIRTH * cell / (HEAD_CELL if is_head else FOOT_CELL)
        return self._hide(solid, patch.limbs, is_head, lumps=lumps, girth=girth)

    def _hide(
        self,
        solid: Solid,
        limbs: list[int],
        is_head: bool = False,
        has_face: bool = False,
        lumps: Sequence[Lump] = (),
        girth: float | None = None,
    ) -> Skin:
        """Return a surface with its paint and its hair.

        Args:
            solid: as the figure stands.
            limbs: numbers of the limbs that it covers.
            is_head: whether it is the skull's.
            has_face: whether the skull is a part of it.
            lumps: whose furrows are darker.
            girth: radius of the part [m]; that of the trunk if left out.
        """
        paint = self.coat.paint(solid, limbs, is_head, has_face)
        if lumps:
            paint = furrowed(paint, lumps, solid, girth or self.coat.girth)
        for lump, color in self.colored:
            share = smoothstep(
                1.0 - 3.0 * lump.distance(solid.vertices) / float(lump.radii_a.min())
            )
            if share.any():
                paint = painted(len(share), color, 0.0) if paint is None else paint
                lay(paint, color, share)
        return self.stance.hide(solid, limbs, paint, self.hair_lay.hair(solid, limbs, is_head))

    def eyes(self) -> Iterator[tuple[int, Skin]]:
        """Yield the numbers of the pieces of the eyes, and their skins."""
        if self.head is None or self.head_limb is None:
            return
        skull_link = self.figure.skeleton.limbs[self.head_limb].links[-1]
        iris = self.figure.skin.iris or self.head.skull.iris
        for number, piece in enumerate(self.figure.pieces):
            if piece.material == EYE_MATERIAL and piece.link == skull_link:
                side = -1.0 if piece.name.endswith("_l") else 1.0
                solid, paint = eyeball(self.head, side, iris)
                yield number, self.stance.rigid(solid, skull_link, paint)
