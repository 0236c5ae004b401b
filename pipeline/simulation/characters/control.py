"""Control: what people do with their nodes before each sub-step.

Source: Horswill 2008, "Low-level character control".
"""

from __future__ import annotations

from pipeline.simulation.characters.arms import hold_arms, stoop
from pipeline.simulation.characters.carriage import halt, lead
from pipeline.simulation.characters.feeling import feel
from pipeline.simulation.characters.gait import tread
from pipeline.simulation.characters.gaze import look
from pipeline.simulation.characters.halting import hold_back, slide
from pipeline.simulation.characters.layout import Crowd
from pipeline.simulation.characters.legs import hold_legs
from pipeline.simulation.characters.muscles import pull
from pipeline.simulation.characters.sitting import sit
from pipeline.simulation.characters.solids import Solids
from pipeline.simulation.characters.steering import avoid
from pipeline.simulation.characters.trunk import hold_trunk, stretch
from pipeline.simulation.dynamics.compiled import Records, compiled
from pipeline.simulation.dynamics.grid import Grid


@compiled
def steer(crowd: Crowd, persons: Records, ground: Grid, solids: Solids, h: float) -> None:
    """Let everybody act for a sub-step of `h` [s], see `layout`."""
    nodes, links, _, _, _, _, owners = crowd
    if len(persons) > 0 and persons[0].since == 0.0:
        avoid(persons)
    for i in range(len(persons)):
        person = persons[i]
        feel(person, nodes, links, owners, h)
        if person.frozen:
            halt(person)
        else:
            lead(person, nodes, ground, h)
            hold_back(person, owners[person.owner].mass, solids, h)
            slide(person, nodes, h)
            tread(person, ground.frame, ground.vertices, h)
            sit(person, h)
            look(person, h)
            stoop(person, h)
            hold_trunk(person, nodes, h)
            hold_legs(person)
            hold_arms(person, h)
        person.since += h
        stretch(person, links, owners)
        pull(person, nodes, h)
