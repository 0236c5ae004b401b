"""Garments: what is worn over shirt and trousers, or in their place.

Skirts of dresses and coats follow the pelvis at the waist, and the thighs the lower the more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.figures.solids import loft
from pipeline.simulation.people.bend_creases import (
    SLEEVED_ELBOW,
    TROUSERED_KNEE,
    hinge_creases,
)
from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.body_mesh import ARM, LEG, on_twisted_arm
from pipeline.simulation.people.cloth_folds import (
    SEAM,
    HangingFolds,
    seam_depth,
    seam_shade,
)
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.shirt_mesh import chest_share, shirt_field, sleeve_air
from pipeline.simulation.people.signed_distance import (
    ellipsoid,
    offset_solid,
    oval_stack,
)
from pipeline.simulation.people.skinned_surface import (
    SkinnedPatch,
    Surface,
    cached_part,
    ellipsoid_surface,
    merge_patches,
    polygonise,
    ramp,
    symmetric_field,
    tube,
    with_mirror,
)
from pipeline.simulation.people.wardrobe import Garment
from pipeline.simulation.spatial import Array, cross, normalized

SKIRT = (
    (0.280, 0.002, 0.096, 0.104, 0.150),
    (0.330, 0.002, 0.088, 0.097, 0.140),
    (0.400, 0.000, 0.077, 0.086, 0.123),
    (0.470, -0.002, 0.067, 0.076, 0.106),
    (0.525, -0.003, 0.062, 0.071, 0.097),
    (0.570, -0.002, 0.059, 0.061, 0.091),
    (0.605, 0.001, 0.054, 0.049, 0.079),
    (0.625, 0.002, 0.048, 0.043, 0.071),
)
"""Outline of a skirt from its hem to its waist; see `BodyMeasures.outline`."""

SKIRT_HEM, COAT_HEM = 0.300, 0.360

FOLDS, FOLD_DEPTH, UNEVEN = 12, 0.0100, 1.1
"""Number of the folds of a skirt, their depth at its hem, in girths, and how unlike they are."""

WORN = 0.0032
"""Distance between two layers of cloth, in an adult's height."""


def _skirt(build: BodyMeasures, hem: float, grown: float) -> SkinnedPatch:
    """Return a skirt down to a height, wider than the usual one by `grown` all around."""
    girth, end = build.girth, build.level(hem)
    outline = build.outline(SKIRT, build.hip_breadth * build.waisted(SKIRT))
    stack = offset_solid(oval_stack(outline), grown * girth)
    waist, seam = build.level(0.60), seam_depth(build, end)

    hanging = HangingFolds(waist, end, FOLDS, FOLD_DEPTH * girth, UNEVEN)

    def folded(places: Array) -> Array:
        result: Array = stack(places) + hanging.depth(places) + seam(places)
        return result

    wide = build.hips + 0.15 * girth
    low = (-0.15 * girth, end, -wide)
    high = (0.15 * girth, build.level(0.64), wide)
    net = polygonise(
        folded, low, high, 0.0145 * girth, stretch=1.4, symmetric=True, hem=end, seam=SEAM * girth
    )
    y, z = net.vertices[:, 1], net.vertices[:, 2]
    falling = 1.0 - ramp(y, build.level(0.40), build.level(0.55))
    share = falling * (0.70 + 0.20 * ramp(np.abs(z), 0.0, 0.06 * girth))
    thigh = np.where(z > 0.0, FRAMES.index("thigh_r"), FRAMES.index("thigh_l"))
    frames = np.stack([np.full(len(z), FRAMES.index("pelvis")), thigh], axis=-1)
    shade = seam_shade(build, end, y) * (1.0 - VALLEY_DARKNESS * hanging.valley(net.vertices))
    return SkinnedPatch(net.vertices, net.faces, frames, share, shade=shade)


VALLEY_DARKNESS = 0.35
"""How dark the bottom of a fold of a skirt is at its hem."""


@cached_part
def skirt(build: BodyMeasures) -> SkinnedPatch:
    """Return a skirt down to the knees."""
    return _skirt(build, SKIRT_HEM, 0.0)


@cached_part
def coat_skirt(build: BodyMeasures) -> SkinnedPatch:
    """Return the lower half of a coat, which ends above the knees."""
    return _skirt(build, COAT_HEM, 3.0 * WORN)


@cached_part
def hood(build: BodyMeasures) -> SkinnedPatch:
    """Return a hood that hangs down the back, and its rim around the neck."""
    g = build.girth
    angle = np.radians(np.linspace(-150.0, 150.0, 13))
    rim = np.stack(
        [
            -0.012 * g - 0.046 * g * np.cos(angle),
            build.level(0.830) - 0.012 * g * (1.0 - np.cos(angle)),
            0.047 * g * np.sin(angle),
        ],
        axis=-1,
    )
    thick = 0.0145 * g * (0.7 + 0.3 * np.cos(angle / 2.0))
    bag = ellipsoid((-0.066 * g, build.level(0.795), 0.0), np.array([0.026, 0.052, 0.062]) * g)
    low = (-0.12 * g, build.level(0.73), -0.09 * g)
    high = (-0.01 * g, build.level(0.86), 0.09 * g)
    hanging = polygonise(bag, low, high, 0.014 * g, symmetric=True)
    return merge_patches([tube(rim, thick, 8).follow("chest"), hanging.follow("chest")])


V_LOW, V_HIGH = 0.688, 0.850
"""Ends of the opening of a jacket, as fractions of an adult's height."""

TIE = ((0.688, 0.0105), (0.815, 0.0070), (0.830, 0.0078), (0.841, 0.0125), (0.850, 0.0100))
"""Heights and half widths of a tie: its blade and its knot."""

TIE_UNDER_LAPELS = 0.004
"""How far the edges of a tie reach under the lapels, in girths."""


@cached_part
def suit_front(build: BodyMeasures) -> SkinnedPatch:
    """Return the shirt between the lapels of a jacket."""
    levels = np.linspace(V_LOW, V_HIGH, 12)
    edge = _opening(levels)
    g = build.girth
    angle = np.radians(np.linspace(8.0, 352.0, 25))
    # Lower in front than in the neck, and drawn out to two points beside the knot of the tie.
    point = ramp(np.abs(angle - np.pi), np.radians(140.0), np.radians(172.0))
    line = np.stack(
        [
            -0.010 * g + (0.0380 + 0.003 * point) * g * np.cos(angle),
            build.level(0.843) - (0.009 * (1.0 + np.cos(angle)) + 0.012 * point) * g,
            (0.0380 + 0.018 * point) * g * np.sin(angle),
        ],
        axis=-1,
    )
    collar = tube(line, (0.0080 - 0.0055 * point) * g, 6).follow("chest")
    return merge_patches([_panel(build, levels, -edge, edge, 0.4), collar])


@cached_part
def lapels(build: BodyMeasures) -> SkinnedPatch:
    """Return the lapels of a jacket, beside its opening."""
    # A step in the outer edge: the collar above, the lapel below it.
    rows = np.array(
        [(0.690, 0.004), (0.730, 0.024), (0.772, 0.036), (0.786, 0.041), (0.787, 0.030),
         (0.805, 0.034), (0.850, 0.040)]
    )  # fmt: skip
    levels = rows[:, 0]
    return with_mirror(_panel(build, levels, _opening(levels) - 0.001, rows[:, 1], 1.5))


@cached_part
def tie(build: BodyMeasures) -> SkinnedPatch:
    """Return a tie, from the collar into the jacket."""
    levels = np.linspace(TIE[0][0], TIE[-1][0], 20)
    half = np.minimum(np.interp(levels, *np.transpose(TIE)), _opening(levels) + TIE_UNDER_LAPELS)
    return _panel(build, levels, -half, half, 0.9)


def _opening(levels: Array) -> Array:
    """Return half the width (n,) of the opening of a jacket at some heights, in girths."""
    return 0.0015 + 0.0265 * (levels - V_LOW) / (V_HIGH - V_LOW)


@cached_part
def bib(build: BodyMeasures) -> SkinnedPatch:
    """Return the bib of dungarees, and its straps over the shoulders."""
    g = build.girth
    line = (
        (0.062, 0.740, 0.044),
        (0.064, 0.780, 0.046),
        (0.050, 0.815, 0.050),
        (0.010, 0.845, 0.053),
        (-0.036, 0.825, 0.050),
        (-0.060, 0.770, 0.036),
        (-0.062, 0.700, 0.020),
        (-0.056, 0.620, 0.010),
    )
    strap = _strap(build, np.array([(x * g, build.level(y), z * g) for x, y, z in line]))
    levels = np.linspace(BIB[0], BIB[1], 12)
    half = np.interp(levels, BIB, BIB_HALVES)
    pocket = np.linspace(*BIB_POCKET, 6)
    pocket_half = np.full(len(pocket), BIB_POCKET_HALF)
    return merge_patches(
        [
            _panel(build, levels, -half, half, 1.0),
            _shaded(_panel(build, pocket, -pocket_half, pocket_half, 1.7), FLAP_SHADE),
            with_mirror(strap),
        ]
    )


BIB, BIB_HALVES = (0.585, 0.745), (0.074, 0.053)
"""Heights of the lower and upper edges of a bib, and half its widths there, in girths."""

BIB_POCKET, BIB_POCKET_HALF = (0.655, 0.712), 0.032
"""Heights of the edges of the pocket of a bib, and half its width, in girths."""


@dataclass(frozen=True, slots=True)
class Front:
    """The front of a garment that opens in the middle.

    Attributes:
        seam: ends of the seam along its edge, as fractions of an adult's height.
        buttons: their heights likewise.
        button: radius of a button, in girths.
        shade: of a button: dark horn, or pale ones of a shirt.
    """

    seam: tuple[float, float]
    buttons: tuple[float, ...]
    button: float
    shade: float


FRONTS: Mapping[Garment, Front] = {
    "suit": Front((0.525, 0.684), (0.634, 0.668), 0.0062, 0.25),
    "coat": Front((0.615, 0.815), (0.640, 0.686, 0.732, 0.778), 0.0062, 0.25),
    "tucked": Front((0.605, 0.822), (0.640, 0.674, 0.708, 0.742, 0.776, 0.810), 0.0036, 0.6),
}
"""Fronts of those garments that have one."""

BUTTON_DEPTH = 0.42
"""Depth of a button, in its radius."""

FRONT_EDGE, FLAP = (0.008, 0.0115), (0.564, 0.580)
"""Ends of the seam along the edge of the front, aside, and heights of the flap of a pocket."""

SEAM_SHADE, FLAP_SHADE = 0.55, 0.85
"""Shades of a seam, and of a flap that lies on the cloth."""


@cached_part
def fastenings(build: BodyMeasures, garment: Garment) -> SkinnedPatch:
    """Return buttons and the seam of the front edge, and the pockets of a jacket."""
    front = FRONTS[garment]
    levels = np.linspace(*front.seam, 14)
    inner, outer = (np.full(len(levels), aside) for aside in FRONT_EDGE)
    parts = [_shaded(_panel(build, levels, inner, outer, 0.25), SEAM_SHADE)]
    parts += [_button(build, front, height) for height in front.buttons]
    if garment == "suit":
        flap = np.linspace(*FLAP, 4)
        ends = np.full(len(flap), 0.036), np.full(len(flap), 0.070)
        parts.append(with_mirror(_shaded(_panel(build, flap, *ends, 0.9), FLAP_SHADE)))
        slit = np.linspace(0.744, 0.752, 3)
        ends = np.full(len(slit), -0.066), np.full(len(slit), -0.042)
        parts.append(_shaded(_panel(build, slit, *ends, 0.6), FLAP_SHADE))
    return merge_patches(parts)


def _shaded(patch: SkinnedPatch, shade: float) -> SkinnedPatch:
    return replace(patch, shade=np.full(len(patch.vertices), shade))


def _button(build: BodyMeasures, front: Front, height: float) -> SkinnedPatch:
    """Return a button on the middle of the front."""
    g, y = build.girth, build.level(height)
    x = float(_front_of_shirt(build, np.array([y]), np.zeros(1))[0])
    radii = front.button * g * np.array([BUTTON_DEPTH, 1.0, 1.0])
    solid = ellipsoid_surface(np.array([x + 0.5 * WORN * g, y, 0.0]), radii, 3, 8)
    share = chest_share(build, solid.vertices[:, 1])
    return _shaded(solid.follow("pelvis", "chest", share), front.shade)


STRAP_STEPS, STRAP_WIDTH, STRAP_WORN = 28, 0.021, 1.6
"""Rings of a strap, its width in girths, and its distance from the shirt, in layers of cloth."""


def _strap(build: BodyMeasures, line: Array) -> SkinnedPatch:
    """Return a flat strap that lies on the shirt along a line (n, 3) about its surface."""
    g, field = build.girth, symmetric_field(shirt_field(build))
    step = 0.002 * g
    at = np.linspace(0.0, len(line) - 1.0, STRAP_STEPS)
    points = np.stack([np.interp(at, np.arange(len(line)), line[:, k]) for k in range(3)], axis=-1)
    for _ in range(6):
        offsets = step * np.eye(3)
        rise = np.stack([field(points + o) - field(points - o) for o in offsets], axis=-1)
        out = normalized(rise)
        slope = np.maximum(np.linalg.norm(rise, axis=-1, keepdims=True) / (2.0 * step), 0.3)
        points = points - np.clip(field(points)[:, None] / slope, -0.02 * g, 0.02 * g) * out
    along = normalized(np.gradient(points, axis=0))
    aside = 0.5 * STRAP_WIDTH * g * normalized(cross(out, along))
    high, low = (points + worn * WORN * g * out for worn in (STRAP_WORN, -1.0))
    rings = np.stack([low - aside, high - 0.8 * aside, high + 0.8 * aside, low + aside], axis=1)
    return _on_trunk(build, rings)


PANEL_COLUMNS = 9
"""Vertices across a panel of cloth."""


def _panel(
    build: BodyMeasures, levels: Array, inner: Array, outer: Array, worn: float
) -> SkinnedPatch:
    """Return cloth on the front of the shirt between two edges, with clean borders.

    Args:
        build: measures of the person.
        levels: (n,) heights, upward, as fractions of an adult's height.
        inner: (n,) one edge at these heights, to the right, in girths.
        outer: (n,) the other edge, further right.
        worn: how far it lies above the shirt, in layers of cloth.
    """
    g = build.girth
    across = np.linspace(0.0, 1.0, PANEL_COLUMNS)
    z = g * (inner[:, None] + (outer - inner)[:, None] * across)
    y = np.repeat(build.levels(levels)[:, None], PANEL_COLUMNS, axis=1)
    above = _front_of_shirt(build, y, z) + worn * WORN * g
    # Its back is inside the shirt.
    sheets = [np.stack([x, y, z], axis=-1) for x in (above, above - (worn + 2.0) * WORN * g)]
    rings = np.concatenate([sheets[1], sheets[0][:, ::-1]], axis=1)
    return _on_trunk(build, rings)


def _on_trunk(build: BodyMeasures, rings: Array) -> SkinnedPatch:
    """Return a solid through rings (n, m, 3) that follows the trunk as a shirt does."""
    solid = loft(rings, rings[[0, -1]].mean(axis=1))
    share = chest_share(build, solid.vertices[:, 1])
    return Surface(solid.vertices, solid.faces).follow("pelvis", "chest", share)


def _front_of_shirt(build: BodyMeasures, y: Array, z: Array) -> Array:
    """Return X of the front of the shirt at heights and places to the right, of one shape [m]."""
    field = symmetric_field(shirt_field(build))
    low, high = np.zeros(y.size), np.full(y.size, 0.15 * build.girth)
    for _ in range(24):
        middle = 0.5 * (low + high)
        inside = field(np.stack([middle, y.ravel(), z.ravel()], axis=-1)) < 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return high.reshape(y.shape)


@cached_part
def stripes(build: BodyMeasures) -> SkinnedPatch:
    """Return the stripes down the sides of a tracksuit's arms and legs."""
    g = build.girth
    patches = []
    for rows, z, hinge, ends, frames in (
        (LEG, build.hips, TROUSERED_KNEE, (0.060, 0.500), ("thigh_r", "shin_r")),
        (ARM, build.shoulders, SLEEVED_ELBOW, (0.522, 0.765), ("upper_arm_r", "forearm_r")),
    ):
        outline = build.outline(rows)
        levels = np.linspace(build.level(ends[0]), build.level(ends[1]), 24)
        thick = sleeve_air(build, "cuffed", levels) if rows is ARM else np.zeros(len(levels))
        x, side = (np.interp(levels, outline[:, 0], outline[:, k]) for k in (1, 4))
        points = np.stack([x, levels, z + side + (thick - 0.0035) * g], axis=-1)
        stripe = tube(points, np.full(len(points), 0.0060 * g), 6)
        reach, joint = 0.030 * g, build.level(hinge.level)
        share = 1.0 - ramp(stripe.vertices[:, 1], joint - reach, joint + reach)
        # As the cloth below, outward of the limb.
        outward = np.broadcast_to([0.0, 0.0, 1.0], stripe.vertices.shape)
        crease = hinge_creases(build, hinge, stripe.vertices, outward, z)
        patch = replace(stripe.follow(*frames, share), crease=crease)
        if rows is ARM:
            patch = on_twisted_arm(build, patch)
        patches.append(patch)
    return with_mirror(merge_patches(patches))
