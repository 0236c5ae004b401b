"""Half planes: the velocity nearest to a wanted one within half planes of allowed ones.

Source: van den Berg, Guy, Lin, Manocha, Reciprocal n-body collision avoidance, 2011, section 5.
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import compiled, inlined
from pipeline.simulation.spatial import Array

PARALLEL = 1e-5  # sine of the angle of two lines that count as parallel


@inlined
def _excess(line: Array, x: float, z: float) -> float:
    """Return how far a velocity lies on the forbidden side of a line [m/s]."""
    result: float = line[2] * (line[1] - z) - line[3] * (line[0] - x)
    return result


@compiled
def allowed_velocity(
    lines: Array, projected: Array, walls: int, count: int, limit: float, x: float, z: float
) -> tuple[float, float]:
    """Return the velocity nearest to a wanted one that all lines allow, or that offends least.

    Args:
        lines: of velocities, first those of walls, then `count` that keep clear of bodies, then
            those of personal space.
        projected: room for as many.
        walls: number of walls.
        count: number of people.
        limit: greatest speed.
        x: of the wanted velocity.
        z: of the wanted velocity.
    """
    bodies, total = walls + count, walls + 2 * count
    failed, x, z = _nearest_velocity(lines, total, limit, x, z, False)
    if failed < walls:
        return _least_offence(lines, projected, 0, failed, walls, limit, x, z)
    if failed < bodies:
        return _least_offence(lines, projected, walls, failed, bodies, limit, x, z)
    return _least_offence(lines, projected, bodies, failed, total, limit, x, z)


@compiled
def velocity_by_braking(
    lines: Array,
    projected: Array,
    walls: int,
    count: int,
    limit: float,
    cost: float,
    x: float,
    z: float,
) -> tuple[float, float]:
    """Return the allowed velocity of a walker that brakes rather than steps aside.

    Without that, two groups that cross carry each other along: a walker that drifts with the
    others never gets past them.

    Args:
        lines: of velocities as of `allowed_velocity`; overwritten.
        projected: room for as many.
        walls: number of walls.
        count: number of people.
        limit: greatest speed along the way.
        cost: of a velocity across the way, relative to one along it.
        x: of the wanted velocity.
        z: of the wanted velocity.
    """
    speed = max(math.hypot(x, z), 1e-9)
    c, s = x / speed, z / speed
    # In coordinates along the way and, stretched, across it.
    for k in range(walls + 2 * count):
        px, pz, dx, dz = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
        lines[k, 0], lines[k, 1] = c * px + s * pz, cost * (c * pz - s * px)
        dx, dz = c * dx + s * dz, cost * (c * dz - s * dx)
        size = math.hypot(dx, dz)
        lines[k, 2], lines[k, 3] = dx / size, dz / size
    along, across = allowed_velocity(lines, projected, walls, count, limit, speed, 0.0)
    across /= cost
    return c * along - s * across, s * along + c * across


@compiled
def _least_offence(
    lines: Array,
    projected: Array,
    hard: int,
    failed: int,
    count: int,
    limit: float,
    x: float,
    z: float,
) -> tuple[float, float]:
    """Return the velocity that keeps the first lines, and offends least against the others.

    Args:
        lines: of velocities, the first `count` rows.
        projected: room for as many.
        hard: number of lines that are kept.
        failed: the first line that cannot be.
        count: number of lines.
        limit: greatest speed.
        x: of the velocity found before.
        z: of the same.
    """
    worst = 0.0
    for i in range(failed, count):
        if _excess(lines[i], x, z) <= worst:
            continue
        # Among the velocities equally far beyond this line and each one before.
        n = hard
        for j in range(hard):
            for k in range(4):
                projected[j, k] = lines[j, k]
        for j in range(hard, i):
            sine = lines[i, 2] * lines[j, 3] - lines[i, 3] * lines[j, 2]
            if abs(sine) <= PARALLEL:
                if lines[i, 2] * lines[j, 2] + lines[i, 3] * lines[j, 3] > 0.0:
                    continue
                projected[n, 0] = 0.5 * (lines[i, 0] + lines[j, 0])
                projected[n, 1] = 0.5 * (lines[i, 1] + lines[j, 1])
            else:
                t = -_excess(lines[j], lines[i, 0], lines[i, 1]) / sine
                projected[n, 0] = lines[i, 0] + t * lines[i, 2]
                projected[n, 1] = lines[i, 1] + t * lines[i, 3]
            dx, dz = lines[j, 2] - lines[i, 2], lines[j, 3] - lines[i, 3]
            size = max(math.hypot(dx, dz), 1e-12)
            projected[n, 2], projected[n, 3] = dx / size, dz / size
            n += 1
        done, new_x, new_z = _nearest_velocity(projected, n, limit, -lines[i, 3], lines[i, 2], True)
        if done == n:
            x, z = new_x, new_z
        worst = _excess(lines[i], x, z)
    return x, z


@compiled
def _nearest_velocity(
    lines: Array, count: int, limit: float, x: float, z: float, farthest: bool
) -> tuple[int, float, float]:
    """Return the first line that cannot be kept, or `count`, and the velocity found so far.

    Args:
        lines: of velocities, the first `count` rows.
        count: number of lines.
        limit: greatest speed.
        x: of the wanted velocity, or of a direction.
        z: of the same.
        farthest: whether the velocity farthest in a direction is wanted.
    """
    goal_x, goal_z = x, z
    size = math.hypot(x, z)
    if farthest:
        x, z = limit * x, limit * z
    elif size > limit:
        x, z = x * limit / size, z * limit / size
    for i in range(count):
        if _excess(lines[i], x, z) > 0.0:
            found, new_x, new_z = _on_line(lines, i, limit, goal_x, goal_z, farthest)
            if not found:
                return i, x, z
            x, z = new_x, new_z
    return count, x, z


@compiled
def _on_line(
    lines: Array, i: int, limit: float, x: float, z: float, farthest: bool
) -> tuple[bool, float, float]:
    """Return whether a velocity on a line keeps all lines before it, and the best of them."""
    px, pz, dx, dz = lines[i, 0], lines[i, 1], lines[i, 2], lines[i, 3]
    middle = px * dx + pz * dz
    square = middle * middle + limit * limit - px * px - pz * pz
    if square < 0.0:
        return False, 0.0, 0.0
    low, high = -middle - math.sqrt(square), -middle + math.sqrt(square)
    for j in range(i):
        sine = dx * lines[j, 3] - dz * lines[j, 2]
        excess = _excess(lines[j], px, pz)
        if abs(sine) <= PARALLEL:
            if excess > 0.0:
                return False, 0.0, 0.0
            continue
        t = -excess / sine
        if sine >= 0.0:
            high = min(high, t)
        else:
            low = max(low, t)
        if low > high:
            return False, 0.0, 0.0
    if farthest:
        t = high if x * dx + z * dz > 0.0 else low
    else:
        t = min(max(dx * (x - px) + dz * (z - pz), low), high)
    return True, px + t * dx, pz + t * dz
