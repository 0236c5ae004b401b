"""Dexterity: how able a limb is to move its tip in all directions.

The thesis measures the distance from a singularity by the determinant of the Jacobian,
which only a square one has: for a redundant limb √det(J Jᵀ), the product of its singular
values, is the same measure. It is without units: lengths count as parts of the limb's.

Source: Sims 1987, 6.3 and B.2; Yoshikawa 1985.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.jacobian import hessian
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.spatial import Array


def singular_values(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return those of the translate Jacobian (L, min(3, n)), the greatest first."""
    J = pose.jacobian / batch.lengths[:, None, None]
    # The explicit type is what numpy promises for doubles, and its stubs do not.
    return np.asarray(np.linalg.svd(J, compute_uv=False), dtype=np.float64)


def dexterity(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return w = √det(J Jᵀ) (L,); the volume over the directions it has, for n < 3 joints."""
    result: Array = np.prod(singular_values(batch, pose), axis=-1)
    return result


def dexterity_gradient(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return ∂w/∂θ (L, n), padding zero.

    ∂w/∂θ_k = w tr(J⁺ ∂J/∂θ_k): with singular values, Σ_i (∏_{j≠i} σ_j) u_iᵀ ∂J/∂θ_k v_i,
    which stays finite where one of them is zero.
    """
    scale = batch.lengths[:, None, None]
    U, σ, Vt = np.linalg.svd((pose.jacobian / scale).transpose(0, 2, 1), full_matrices=False)
    others = np.stack(
        [np.prod(np.delete(σ, i, axis=-1), axis=-1) for i in range(σ.shape[-1])], axis=-1
    )
    change = hessian(batch, pose)[..., :3] / scale[..., None]
    G = (U * others[:, None, :]) @ Vt
    result: Array = np.einsum("lxj,lkjx->lk", G, change)
    return result
