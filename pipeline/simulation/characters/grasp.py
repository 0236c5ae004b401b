"""Grasp: what hands can hold of members of other rooms, where they take it, and how it is held."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.dynamics.mass import volume_of_solid
from pipeline.simulation.members import MemberState
from pipeline.simulation.obstacles import directions
from pipeline.simulation.spatial import Array

HAND_SPAN = 0.116  # widest thing that one hand takes, in heights: 0.2 m of an adult
EMBRACE_WIDTH = 0.07  # widest thing between two hands, beyond the shoulders, in heights
ONE_HAND_MASS, TWO_HAND_MASS = 0.15, 0.5  # heaviest things, in the person's mass
PROP_DENSITY = 600.0  # of things that are not known to have a mass [kg/m³]
PALM = 0.045  # from the wrist to the middle of the palm, in heights
WIDTH_DIRECTIONS = 96
LOWERING_RANGE = 0.3  # of a hand beside its place, from which it goes down, in arm lengths
LIFTED, LIFT_SLOPE = 0.9, 1.5  # height up to which it stays above that, in arm lengths; its slope


def width_of(state: MemberState) -> float:
    """Return the least extent of a member in any direction [m]."""
    if not state.solids:
        return 0.0
    along = np.concatenate(state.solids) @ directions(WIDTH_DIRECTIONS).T
    return float(np.ptp(along, axis=0).min())


def mass_of(controller: PersonController, name: str) -> float:
    """Return the mass of a member [kg]."""
    view = controller.view
    owner = view.owner(name)
    if owner >= 0:
        return float(view.arrays.owners["mass"][owner])
    if name in view.body_masses:
        return view.body_masses[name]
    hulls = [hull_of(solid) for solid in view.state(name).solids]
    return PROP_DENSITY * sum(volume_of_solid(hull.vertices, hull.faces) for hull in hulls)


def hands_needed(controller: PersonController, name: str) -> tuple[int, ...]:
    """Return the hands that take a member if the author names none: one, or both."""
    return (1,) if not grasp_failure(controller, name, (1,)) else (0, 1)


def grasp_failure(
    controller: PersonController, name: str, hands: tuple[int, ...], share: float = 1.0
) -> str:
    """Return why hands cannot hold a member, "" if they can.

    Args:
        controller: of the person.
        name: of the member.
        hands: numbers of the hands.
        share: of the weight that they bear; several take a thing by its edges, however wide.
    """
    person, state = controller.record, controller.view.state(name)
    if not state.is_present:
        return f"'{name}' is not there"
    own = float(controller.view.arrays.owners["mass"][person.owner])
    if len(hands) == 2:
        text, widest = "both hands", 2.0 * float(person.shoulders) + EMBRACE_WIDTH * person.height
        heaviest = TWO_HAND_MASS * own
    else:
        text, widest, heaviest = "a hand", HAND_SPAN * person.height, ONE_HAND_MASS * own
    width, mass = width_of(state), share * mass_of(controller, name)
    if share == 1.0 and width > widest:
        return f"wider than {text} ({_more_than(width, widest, 3)} m)"
    if mass > heaviest:
        return f"too heavy for {text} ({_more_than(mass, heaviest, 1)} kg)"
    return ""


def _more_than(size: float, most: float, digits: int) -> str:
    """Return a size and what can be held at most, so rounded that the size is seen to be more."""
    scale = 10.0**digits
    above, below = math.ceil(size * scale) / scale, math.floor(most * scale) / scale
    return f"{above:.{digits}f} of at most {below:.{digits}f}"


def grasp_place(controller: PersonController, state: MemberState, k: int, both: bool) -> Array:
    """Return (3,) where the wrist of a hand goes to take a member [m].

    One hand takes it where it is nearest to the shoulder, both from the sides.
    """
    palm = PALM * float(controller.record.height)
    if not both:
        shoulder = controller.shoulder(k)
        place = state.nearest(shoulder)
        offset = shoulder - place
        return place + palm * offset / max(float(np.linalg.norm(offset)), 1e-9)
    ahead = controller.direction_to(state.centre)
    right = np.array([-ahead[2], 0.0, ahead[0]])
    side = 1.0 if k == 1 else -1.0
    half, depth = half_extent(state, right), half_extent(state, ahead)
    reach = 1.3 * float(controller.record.shoulders) + palm
    # Long things are taken by their near side.
    near = max(depth - palm, 0.0) if half > reach else 0.5 * depth
    aside = min(half, reach) + 0.4 * palm
    return state.centre + side * aside * right - near * ahead


def lift_over_knees(controller: PersonController, k: int, wrist: Array) -> Array:
    """Return (3,) how far above its place a hand goes: first ahead of the knees, then down [m]."""
    (x, y, z), (hand_x, _, hand_z) = wrist.tolist(), controller.hand(k).tolist()
    aside = math.hypot(x - hand_x, z - hand_z) - LOWERING_RANGE * controller.arm
    above = max(float(controller.record.floor) + LIFTED * controller.arm - y, 0.0)
    return np.array([0.0, min(LIFT_SLOPE * max(aside, 0.0), above), 0.0])


def half_extent(state: MemberState, direction: Array) -> float:
    """Return half the extent of a member along a unit vector [m]."""
    if not state.solids:
        return 0.0
    return 0.5 * float(np.ptp(np.concatenate(state.solids) @ direction))


def hold_members(controller: PersonController) -> None:
    """Hold members of other rooms: small ones in a hanging hand, others before the waist."""
    for name in dict.fromkeys(controller.held_members.values()):
        if len(controller.hands_holding(name)) == 2:
            state = controller.view.state(name)
            ahead = controller.ahead
            right = np.array([-ahead[2], 0.0, ahead[0]])
            reach = 1.3 * float(controller.record.shoulders)
            width = min(half_extent(state, right), reach) + 0.4 * PALM * controller.record.height
            for k in range(2):
                place = controller.place_before(k, width, half_extent(state, ahead))
                controller.lead_hand(k, place)
