"""Casting: assigns the performers of a scene to troupes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import TypeGuard

from pipeline.errors import Problem, SceneError
from pipeline.simulation.bodies.groups.group_troupe import GroupTroupe
from pipeline.simulation.bodies.prop_paths import guided_solid, is_guided
from pipeline.simulation.bodies.prop_troupe import PropTroupe
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.figure_checks import check_figure
from pipeline.simulation.inventory import obstacles_of
from pipeline.simulation.locomotion.inching.inchworm_chain import is_inchworm
from pipeline.simulation.locomotion.inching.inchworm_troupe import InchwormTroupe
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.people.dressed_figure import PERSON_HINT, check_person, is_person
from pipeline.simulation.people.guided_dance import DanceGuide
from pipeline.simulation.people.proportions import Proportions
from pipeline.simulation.people.wardrobe import Clothes, deal_clothes
from pipeline.simulation.refusals import Refusals
from pipeline.simulation.take import TakeNote
from pipeline.simulation.terrain import level_ground
from pipeline.simulation.troupe import Troupe, World
from pipeline.spec.body import Body, Many
from pipeline.spec.cast import Member
from pipeline.spec.character import Character
from pipeline.spec.character_kinds import WEARERS
from pipeline.spec.costume import HairLook
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.group import Group
from pipeline.spec.handled_members import handled_members
from pipeline.spec.prop import Prop
from pipeline.spec.scene import Scene

Performer = tuple[int, Creature, Figure]
"""Number in the cast, configuration and figure."""

CREATURE_MATERIAL, PROP_MATERIAL = "brown chitin", "wood"
"""Default materials of creatures and of props."""


def figures_of(scene: Scene) -> dict[str, Figure]:
    """Returns the figure of each creature by its name; equal ones are shared.

    Raises:
        SceneError: if figures cannot be built; holds the problems of all.
    """

    @cache
    def built(name: str, scale: float) -> Figure:
        figure = build_figure(name, scene.figures[name], scale)
        check_person(figure)
        return figure

    figures, refusals = dict[str, Figure](), Refusals()
    for _, member in scene.creatures:
        with refusals.gathered():
            figures[member.name] = built(member.figure, member.scale)
    refusals.refuse()
    return figures


def drawing_notes(figures: Mapping[str, Figure]) -> list[TakeNote]:
    """Returns notes on likely mistakes in the drawings of creatures, once for each figure."""
    owners = {figure.name: name for name, figure in reversed(list(figures.items()))}
    return [
        TakeNote("drawn", 0, f"{name}.{remark.node}", remark.text)
        for name, figure in figures.items()
        if owners[figure.name] == name
        for remark in check_figure(figure)
        if remark.is_fault
    ]


def clothes_of(scene: Scene, figures: Mapping[str, Figure]) -> dict[str, Clothes]:
    """Returns what the people of a scene wear, dealt over all of them together.

    Raises:
        SceneError: if a creature that is no person is given a costume or hair.
    """
    people: dict[str, Character | Creature | Dancer] = {m.name: m for _, m in scene.dancers}
    problems = []
    for i, member in enumerate(scene.cast):
        if isinstance(member, Character) and member.character in WEARERS:
            people[member.name] = member
        elif isinstance(member, Creature) and is_person(figures[member.name]):
            people[member.name] = member
        elif isinstance(member, Creature):
            for key, nothing in (("costume", "wears nothing"), ("hair", "has no such hair")):
                if getattr(member, key) is not None:
                    message = f"the figure '{member.figure}' {nothing}; remove this"
                    problems.append(Problem(f"cast[{i}].{key}", f"{message}, or {PERSON_HINT}"))
    if problems:
        raise SceneError(problems)
    dealt = deal_clothes({name: member.costume for name, member in people.items()}, scene.seed)
    return {name: _as_told(member, dealt[name]) for name, member in people.items()}


def _as_told(member: Character | Creature | Dancer, dealt: Clothes) -> Clothes:
    """Returns the clothes that a person is dealt, with what its author says."""
    hair = member.hair or HairLook()
    return replace(
        dealt,
        shirt=member.material or dealt.shirt,
        style=hair.style or dealt.style,
        hair=hair.material or dealt.hair,
        hair_length=hair.length,
    )


def troupes_of(scene: Scene, figures: dict[str, Figure], world: World) -> list[Troupe]:
    """Returns the troupes of a scene, in the order of their nodes.

    Raises:
        SceneError, SimulationError: if performers cannot be built; holds all problems.
    """
    cast, refusals = list(enumerate(scene.cast)), Refusals()
    handled = handled_members(scene, world.directed)
    guided = [m for _, m in cast if isinstance(m, Prop) and is_guided(m) and m.name not in handled]
    with refusals.gathered():
        world = replace(world, solids=tuple(guided_solid(member, world) for member in guided))
    troupes = _creatures(scene, figures, world, refusals)
    meeting = [(i, member) for i, member in cast if _meets_all(member, handled)]
    bodies = [member.name for _, member in meeting]
    props = [m for _, m in cast if isinstance(m, Prop) and m.name not in bodies]
    if props:
        with refusals.gathered():
            troupes.append(PropTroupe(props, world, [m.material or PROP_MATERIAL for m in props]))
    # Rooms that load MuJoCo or a compiler are imported only where they are needed.
    if scene.dancers:
        from pipeline.simulation.dancers.dancer_troupe import DancerTroupe

        with refusals.gathered():
            troupes.append(DancerTroupe(scene.dancers, scene.dances, world))
    # Characters push bodies through the contact coupling instead.
    pushing = [troupe.inventory for troupe in troupes]
    characters = scene.characters
    if characters:
        from pipeline.simulation.characters.characters import Characters

        with refusals.gathered():
            troupes.append(Characters(characters, world, _guide_maker(scene, world)))
    on_ground = [(i, m) for i, m in cast if isinstance(m, Body) and m.name not in bodies]
    if on_ground:
        from pipeline.simulation.bodies.ground_body_troupe import GroundBodyTroupe

        materials = [member.material or PROP_MATERIAL for _, member in on_ground]
        with refusals.gathered():
            troupes.append(GroundBodyTroupe(on_ground, world, materials))
    if meeting:
        from pipeline.simulation.bodies.collider_troupe import ColliderTroupe

        materials = [member.material or PROP_MATERIAL for _, member in meeting]
        with refusals.gathered():
            obstacles = obstacles_of(pushing)
            troupes.append(ColliderTroupe(meeting, world, materials, obstacles, handled))
    groups = [(i, member) for i, member in cast if isinstance(member, Group)]
    if groups:
        with refusals.gathered():
            troupes.append(GroupTroupe(groups, world))
    refusals.refuse()
    return troupes


def _guide_maker(scene: Scene, world: World) -> Callable[[str, Proportions], DanceGuide]:
    """Returns what makes the dances of people that are no dancers."""

    def made(name: str, proportions: Proportions) -> DanceGuide:
        from pipeline.simulation.dancers.person_dance import PersonDances

        return PersonDances(name, proportions, scene.dances, world.clock)

    return made


def _meets_all(member: Member, handled: Collection[str]) -> TypeGuard[Body | Many | Prop]:
    """Returns whether a member is simulated as bodies that meet one another.

    Args:
        member: of the cast.
        handled: names of what people may hold or kick.
    """
    if isinstance(member, Body):
        return member.body.collide == "all" or bool(member.held) or member.name in handled
    if isinstance(member, Prop):
        return member.may_fall or member.name in handled
    return isinstance(member, Many)


def _creatures(
    scene: Scene, figures: dict[str, Figure], world: World, refusals: Refusals
) -> list[Troupe]:
    """Returns the troupes of creatures; on a parent they stand on level ground of their own."""
    troupes = list[Troupe]()
    for level in dict.fromkeys(_parent_level(member) for _, member in scene.creatures):
        here = [(i, m, figures[m.name]) for i, m in scene.creatures if _parent_level(m) == level]
        hoppers = [p for p in here if p[1].pronk is not None and p[1].walk is None]
        worms = [p for p in here if p not in hoppers and _is_inchworm(p)]
        walkers = [p for p in here if p not in hoppers and p not in worms]
        ground = world.ground if level is None else level_ground(level, world.ground)
        there = replace(world, ground=ground, solids=world.solids if level is None else ())
        if walkers:
            with refusals.gathered():
                materials, guide = _default_materials(walkers), _guide_maker(scene, world)
                troupes.append(WalkerTroupe(walkers, there, materials, guide))
        if hoppers:
            with refusals.gathered():
                troupes.append(HopperTroupe(hoppers, there, _default_materials(hoppers)))
        if worms:
            with refusals.gathered():
                troupes.append(InchwormTroupe(worms, there, _default_materials(worms)))
    return troupes


def _is_inchworm(performer: Performer) -> bool:
    """Returns whether a creature moves as an inchworm; a posed one is moved by its author."""
    _, member, figure = performer
    return is_inchworm(figure) and not member.pose


def _parent_level(member: Creature) -> float | None:
    """Returns the height in its parent's frame that a creature stands at; None for the ground."""
    if member.parent is None:
        return None
    return member.at[1] if len(member.at) == 3 else 0.0


def _default_materials(performers: Sequence[Performer]) -> list[str]:
    """Returns the default materials of performers whose figures name none."""
    return [m.material or figure.material or CREATURE_MATERIAL for _, m, figure in performers]
