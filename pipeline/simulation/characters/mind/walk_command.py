"""Walk command: a mind's decision to walk or stand, written into the record of its person.

In what manner it does that, or a task, is written by itself.
"""

from __future__ import annotations

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.person_record import REACHING, STANDING, SWINGING
from pipeline.simulation.dynamics.compiled import Record, Records, entry

MIN_PACE = 0.05  # [m/s]


def write_manner(person: Record, command: MotorCommand, startled: bool) -> None:
    """Write in what manner a person carries out a command.

    Args:
        person: `PERSON` record; changed.
        command: of its mind.
        startled: whether it starts back from pain now.
    """
    person.frozen = person.fearful = command.frozen
    person.startled, person.pace = startled, max(command.pace, MIN_PACE)


@entry
def write_walk_command(
    persons: Records,
    grips: IntArray,
    k: int,
    goes: bool,
    x: float,
    z: float,
    partner: int,
    faces: bool,
    facing: float,
    reaching: bool,
) -> None:
    """Command a person to walk, or to stand; hands that hold nothing hang or reach ahead.

    Args:
        persons: `PERSON` records; changed.
        grips: of all characters.
        k: index of the person.
        goes: whether it walks.
        x: of its goal [m].
        z: of the same.
        partner: number of the character that is not stepped aside for, or NOBODY.
        faces: whether it keeps facing a heading.
        facing: that heading [rad].
        reaching: whether free hands are held out ahead.
    """
    person = persons[k]
    person.posture, person.has_goal, person.has_facing = STANDING, goes, faces
    if goes:
        person.goal[0], person.goal[1] = x, z
        person.stop_distance, person.neighbour_distance = 0.0, float("inf")
        person.partner = partner
    if faces:
        person.facing = facing
    for hand in range(2):
        if grips[person.grip + hand, 1] < 0:
            person.arm_mode[hand] = REACHING if reaching else SWINGING
