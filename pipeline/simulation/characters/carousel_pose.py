"""Carousel pose: how a merry-go-round stands now, and the ways onto its deck and off."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.carousel_places import (
    GAP_ANGLE,
    CarouselPose,
    CarouselSurvey,
)
from pipeline.simulation.characters.character_view import CharacterView
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.playthings import SPOKES
from pipeline.simulation.dynamics.compiled import Records, bound, compiled, entry
from pipeline.simulation.spatial import Array

OUTSIDE, INSIDE = 0.1, 0.45
"""Distances from the rim at which a person stands before it, clear of it, and on the deck [m]."""

GAP_TOLERANCE = 0.16
"""Angle to the middle of a gap within which a person passes between two posts [rad]."""


def carousel_pose(view: CharacterView, owner: int) -> CarouselPose:
    """Return a merry-go-round as it stands now."""
    decks = view.decks
    pose = decks.poses.get(owner)
    if pose is None:
        survey = decks.surveys.get(owner)
        if survey is None:
            survey = decks.surveys[owner] = _survey(view, owner)
        p, (radius, angle) = survey.p.copy(), survey.measure_deck()
        ends = p[2 : 2 + SPOKES], p[2 + SPOKES :]
        pose = CarouselPose(survey.first, p[0], radius, angle, *ends, survey.measure_rate)
        decks.poses[owner] = pose
    return pose


def _survey(view: CharacterView, owner: int) -> CarouselSurvey:
    first = view.first_node(owner)
    nodes = view.arrays.nodes[first : first + 2 + 2 * SPOKES]
    rate = bound(_turning_rate, nodes, view.sub_step)
    return CarouselSurvey(first, nodes["p"], bound(_measure_deck, nodes), rate)


@entry
def _measure_deck(nodes: Records) -> tuple[float, float]:
    """Return the radius of a deck [m], and the angle of its first post [rad]."""
    distances, sine, cosine = np.empty(SPOKES), 0.0, 0.0
    for n in range(SPOKES):
        hub, rim = nodes[0], nodes[2 + n]
        distances[n] = math.sqrt(_square(nodes, n))
        angle = math.atan2(hub.p[2] - rim.p[2], rim.p[0] - hub.p[0]) - n * GAP_ANGLE
        sine += math.sin(angle)
        cosine += math.cos(angle)
    return _mean(distances) + nodes[0].radius, math.atan2(sine, cosine)


@entry
def _turning_rate(nodes: Records, h: float) -> float:
    """Return how fast a merry-go-round turns, for sub-steps of `h` [rad/s], [s]."""
    rates = np.empty(SPOKES)
    for n in range(SPOKES):
        hub, rim = nodes[0], nodes[2 + n]
        x, z = rim.p[0] - hub.p[0], rim.p[2] - hub.p[2]
        v_x, v_z = (rim.p[0] - rim.previous[0]) / h, (rim.p[2] - rim.previous[2]) / h
        rates[n] = (z * v_x - x * v_z) / _square(nodes, n)
    return _mean(rates)


@compiled
def _square(nodes: Records, n: int) -> float:
    """Return the square of the distance of a post from the hub [m²]."""
    hub, rim = nodes[0], nodes[2 + n]
    x, y, z = rim.p[0] - hub.p[0], rim.p[1] - hub.p[1], rim.p[2] - hub.p[2]
    return x * x + y * y + z * z


@compiled
def _mean(a: Array) -> float:
    """Return the mean of SPOKES numbers, added in pairs, as NumPy does."""
    total = ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]))
    return total / SPOKES


def way_across_rim(
    controller: PersonController,
    carousel: CarouselPose,
    angle: float,
    goal_distance: float,
    lead: float = 0.0,
) -> Array | None:
    """Return the next place (3,) on the way between two posts, None once across the rim [m].

    Args:
        controller: of the person.
        carousel: that is stepped onto, or off.
        angle: of the middle of the gap [rad].
        goal_distance: of the goal from the hub: less than its radius to step on [m].
        lead: by which the gap turns until the person is there [rad].
    """
    person = controller.record
    own = controller.ground_distance(carousel.hub)
    off = angle - carousel.angle_of(*person.at.tolist())
    off = math.remainder(off, 2.0 * math.pi)
    outer = carousel.radius + controller.body_radius + OUTSIDE
    inner = carousel.radius - INSIDE
    goes_in = goal_distance < carousel.radius
    if (goes_in and own < inner + 0.1) or (not goes_in and own > outer - 0.1):
        return None
    if abs(off) > GAP_TOLERANCE:
        return carousel.place(angle + lead, inner if own < carousel.radius else outer)
    return carousel.place(angle + lead, inner - 0.2 if goes_in else outer + 0.2)


def way_off_deck(controller: PersonController, goal: Array | tuple[float, float]) -> Array | None:
    """Return the next place (2,) of a person that leaves a merry-go-round for a goal (2,) [m].

    Pushers see that it wants to get off, and slow down. It is None for one that stands on none, or
    whose goal is on it.
    """
    person = controller.record
    if person.deck_share == 0.0 or person.deck < 0:
        return None
    carousel = carousel_pose(controller.view, int(person.deck))
    distance = math.dist(goal, carousel.hub[[0, 2]])
    if distance < carousel.radius:
        return None
    controller.view.decks.leaving[int(person.deck)].add(int(person.owner))
    gap = carousel.gap_angle(carousel.angle_of(*person.at.tolist()))
    way = way_across_rim(controller, carousel, gap, distance)
    return None if way is None else way[[0, 2]]
