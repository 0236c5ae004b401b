"""Casting: who of a scene's cast goes into which troupe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from pipeline.simulation.bodies.groups.group_troupe import GroupTroupe
from pipeline.simulation.bodies.prop_troupe import PropTroupe
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.inventory import obstacles_of
from pipeline.simulation.locomotion.inching.inchworm_chain import is_inchworm
from pipeline.simulation.locomotion.inching.inchworm_troupe import InchwormTroupe
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.walking import Walkers
from pipeline.simulation.terrain import level_ground
from pipeline.simulation.troupe import Troupe, World
from pipeline.spec.body import Body, Many
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.group import Group
from pipeline.spec.prop import Prop
from pipeline.spec.scene import Scene

Performer = tuple[int, Creature, Figure]
"""Place in the cast, words and figure."""

SKIN, THING = "brown chitin", "wood"
"""Materials of creatures and of props that name none, neither themselves nor in their figures."""


def figures_of(scene: Scene) -> dict[str, Figure]:
    """Return the figure of each creature by its name; those alike at one scale share theirs."""
    built = cache(lambda name, scale: build_figure(name, scene.figures[name], scale))
    return {member.name: built(member.figure, member.scale) for _, member in scene.creatures}


def troupes_of(scene: Scene, figures: dict[str, Figure], world: World) -> list[Troupe]:
    """Sort the cast into troupes, those first who look at nobody else."""
    troupes = [*_creatures(scene, figures, world)]
    props = [member for member in scene.cast if isinstance(member, Prop)]
    if props:
        troupes.append(PropTroupe(props, world, [member.material or THING for member in props]))
    if scene.dancers:
        # MuJoCo is loaded by those alone who need it.
        from pipeline.simulation.dancers.dancer_troupe import Dancers

        troupes.append(Dancers(scene.dancers, scene.dances, world))
    # Characters are not among them: they run into bodies themselves, and feel what these weigh.
    pushing = [troupe.inventory for troupe in troupes]
    characters = [member for member in scene.cast if isinstance(member, Character)]
    if characters:
        # As below: they need a compiler.
        from pipeline.simulation.characters.characters import Characters

        troupes.append(Characters(characters, world))
    troupes += _alone(scene, world)
    meeting = [
        (i, member)
        for i, member in enumerate(scene.cast)
        if isinstance(member, Many) or (isinstance(member, Body) and member.body.collide == "all")
    ]
    if meeting:
        # Bodies need a compiler, whose loading others need not wait for.
        from pipeline.simulation.bodies.collider_troupe import ColliderTroupe

        made_of = [member.material or THING for _, member in meeting]
        troupes.append(ColliderTroupe(meeting, world, made_of, obstacles_of(pushing)))
    groups = [(i, member) for i, member in enumerate(scene.cast) if isinstance(member, Group)]
    if groups:
        troupes.append(GroupTroupe(groups, world))
    return troupes


def makes_machine_code(scene: Scene) -> bool:
    """Tell whether the machine code of bodies is made first, which takes a while, once."""
    rooms = {
        "dynamics": any(isinstance(member, Body | Many) for member in scene.cast),
        "characters": any(isinstance(member, Character) for member in scene.cast),
    }
    if not any(rooms.values()):
        return False
    from pipeline.simulation.dynamics.compiled import is_cached

    return not all(is_cached(room) for room, needed in rooms.items() if needed)


def _creatures(scene: Scene, figures: dict[str, Figure], world: World) -> list[Troupe]:
    """Return the troupes of creatures; on a parent they stand on level ground of its own."""
    troupes = list[Troupe]()
    for level in dict.fromkeys(_level(member) for _, member in scene.creatures):
        here = [(i, m, figures[m.name]) for i, m in scene.creatures if _level(m) == level]
        hop = [one for one in here if one[1].pronk is not None and one[1].walk is None]
        worms = [one for one in here if one not in hop and _inches(one)]
        walkers = [one for one in here if one not in hop and one not in worms]
        ground = world.ground if level is None else level_ground(level, world.ground)
        there = replace(world, ground=ground)
        if walkers:
            troupes.append(Walkers(walkers, there, _materials(walkers)))
        if hop:
            troupes.append(HopperTroupe(hop, there, _materials(hop)))
        if worms:
            troupes.append(InchwormTroupe(worms, there, _materials(worms)))
    return troupes


def _alone(scene: Scene, world: World) -> list[Troupe]:
    """Return the troupe of bodies that meet the ground alone, if there are any."""
    alone = [
        (i, member)
        for i, member in enumerate(scene.cast)
        if isinstance(member, Body) and member.body.collide == "terrain"
    ]
    if not alone:
        return []
    from pipeline.simulation.bodies.ground_body_troupe import GroundBodyTroupe

    return [GroundBodyTroupe(alone, world, [member.material or THING for _, member in alone])]


def _inches(performer: Performer) -> bool:
    """Tell whether a creature moves as an inchworm; one that is posed is its author's to move."""
    _, member, figure = performer
    return is_inchworm(figure) and not member.pose


def _level(member: Creature) -> float | None:
    """Return the height in its parent's frame that a creature stands at; None for the ground."""
    if member.parent is None:
        return None
    return member.at[1] if len(member.at) == 3 else 0.0


def _materials(performers: Sequence[Performer]) -> list[str]:
    """Return what performers are made of where their figures do not say."""
    return [m.material or figure.material or SKIN for _, m, figure in performers]
