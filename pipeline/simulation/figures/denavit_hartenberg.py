"""Denavit-Hartenberg parameters of a figure, and poses from them.

The frame of a joint has its z along the joint's axis. Four numbers lead to it from the frame of
the joint before: turn by θ about z, move by r along z, move by a along the new x, turn by α about
it. That is

    F_j(q) = F_p(q) Z_p(q_p) Rz(θ_j) Tz(r_j) Tx(a_j) Rx(α_j),

where Z_p is the motion of joint p about or along its own z: its value is added to θ_j where it
turns and to r_j where it slides. The row of a joint thus stands for the link before it; its x lies
along the common normal of the two axes. As every child has its own θ and r on its parent's axis,
links may branch, which the notation does not cover.

The body's frame is the creation frame, and stands for a joint of value zero. Four numbers cannot
hold where along its axis, and how turned about it, a joint's frame stands: each joint has a tool,
the pose in F_j of the frame used elsewhere, which is parallel to the creation frame at joint
values zero and has its origin at the joint's place.

Where two axes are parallel the common normal passes through the parent's origin (r = 0); where
they intersect, x is at right angles to both; where they coincide, θ = r = a = 0. Axes that are
nearly parallel, by less than a millionth, are the notation's known weakness: their common normal
is far away, and digits are lost on the way there and back.

Source: Denavit and Hartenberg 1955; Sims 1987, 5.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.skeleton import BODY, Skeleton
from pipeline.simulation.spatial import Array

PARALLEL = 1e-8
"""Sine of the angle below which two axes count as parallel."""


@dataclass(frozen=True, eq=False)
class Denavit:
    """A figure in Denavit-Hartenberg notation.

    Attributes:
        parents: (J,) joint before each; `BODY` for joints on the body.
        prismatic: (J,) whether a joint slides.
        theta, r, a, alpha: (J,) [rad, m, m, rad].
        tools: (J, 4, 4) frames of the joints, as in `JointTree`, in those of this notation.
    """

    parents: NDArray[np.int64]
    prismatic: NDArray[np.bool_]
    theta: Array
    r: Array
    a: Array
    alpha: Array
    tools: Array


@dataclass(frozen=True, slots=True)
class DenavitRow:
    """One joint in a table, angles in degrees."""

    joint: str
    parent: str
    kind: str
    theta_deg: float
    r: float
    a: float
    alpha_deg: float


def to_denavit(skeleton: Skeleton) -> Denavit:
    """Return a figure's parameters."""
    count = len(skeleton.parents)
    parameters = np.zeros((count, 4))
    frames, tools = np.zeros((2, count, 4, 4))
    for j in _outward(skeleton.parents):
        parent = int(skeleton.parents[j])
        F = np.eye(4) if parent == BODY else frames[parent]
        R, p = F[:3, :3], F[:3, 3]
        place, axis = R.T @ (skeleton.places[j] - p), R.T @ skeleton.axes[j]
        parameters[j] = _parameters(place, axis)
        # Computed from the stored numbers, so that their rounding is not passed on.
        frames[j] = F @ _link(*parameters[j])
        X = np.eye(4)
        X[:3, 3] = skeleton.places[j]
        tools[j] = _inverse(frames[j]) @ X
    theta, r, a, alpha = parameters.T
    return Denavit(skeleton.parents, skeleton.prismatic, theta, r, a, alpha, tools)


def from_denavit(figure: Denavit, q: Array) -> Array:
    """Return the frames X_BJ (..., J, 4, 4) of all joints relative to the body.

    They equal those of `JointTree.pose`.

    Args:
        figure: its parameters.
        q: (..., J) joint values [rad or m].
    """
    F = np.zeros((*q.shape, 4, 4))
    moved, result = np.zeros_like(F), np.zeros_like(F)
    for j in _outward(figure.parents):
        parent = int(figure.parents[j])
        link = _link(figure.theta[j], figure.r[j], figure.a[j], figure.alpha[j])
        F[..., j, :, :] = link if parent == BODY else moved[..., parent, :, :] @ link
        moved[..., j, :, :] = F[..., j, :, :] @ _along_z(q[..., j], bool(figure.prismatic[j]))
        result[..., j, :, :] = moved[..., j, :, :] @ figure.tools[j]
    return result


def denavit_table(skeleton: Skeleton) -> list[DenavitRow]:
    """Return one row a joint, for display."""
    figure = to_denavit(skeleton)
    return [
        DenavitRow(
            joint=name,
            parent="body" if parent == BODY else skeleton.joint_names[parent],
            kind="prismatic" if slides else "revolute",
            theta_deg=math.degrees(theta),
            r=float(r),
            a=float(a),
            alpha_deg=math.degrees(alpha),
        )
        for name, parent, slides, theta, r, a, alpha in zip(
            skeleton.joint_names,
            figure.parents,
            figure.prismatic,
            figure.theta,
            figure.r,
            figure.a,
            figure.alpha,
            strict=True,
        )
    ]


def _outward(parents: NDArray[np.int64]) -> list[int]:
    """Return the joints in an order in which each follows its parent."""
    order, left = list[int](), set(range(len(parents)))
    while left:
        here = sorted(j for j in left if int(parents[j]) not in left)
        order += here
        left -= set(here)
    return order


def _parameters(place: Array, axis: Array) -> tuple[float, float, float, float]:
    """Return θ, r, a, α from a frame to a line through `place` (3,) along `axis` (3,)."""
    x, y, z = axis
    sine = math.hypot(x, y)
    if sine < PARALLEL:
        a = math.hypot(place[0], place[1])
        theta = math.atan2(place[1], place[0]) if a > 0.0 else 0.0
        return theta, 0.0, a, math.atan2(0.0, z)
    # x along z × axis; of its two directions the one that gives a ≥ 0.
    normal = np.array([-y, x, 0.0]) / sine
    a = float(normal @ place)
    if a < 0.0:
        normal, a = -normal, -a
    theta = math.atan2(normal[1], normal[0])
    # After θ and r the axis is (0, -sin α, cos α).
    alpha = math.atan2(normal[1] * x - normal[0] * y, z)
    # The point of the line nearest to z has the horizontal part a·normal.
    along = (place[0] * x + place[1] * y) / sine**2
    return theta, float(place[2] - along * z), a, alpha


def _link(theta: float, r: float, a: float, alpha: float) -> Array:
    """Return Rz(θ) Tz(r) Tx(a) Rx(α) (4, 4)."""
    c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
    return np.array(
        [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0.0, sa, ca, r],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def _along_z(q: Array, slides: bool) -> Array:
    """Return the motion of a joint of value `q` (...) about or along its z (..., 4, 4)."""
    X = np.zeros((*q.shape, 4, 4))
    X[...] = np.eye(4)
    if slides:
        X[..., 2, 3] = q
        return X
    c, s = np.cos(q), np.sin(q)
    X[..., 0, 0], X[..., 0, 1], X[..., 1, 0], X[..., 1, 1] = c, -s, s, c
    return X


def _inverse(X: Array) -> Array:
    result = np.eye(4)
    result[:3, :3] = X[:3, :3].T
    result[:3, 3] = -X[:3, :3].T @ X[:3, 3]
    return result
