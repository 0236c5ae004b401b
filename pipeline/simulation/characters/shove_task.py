"""Shove task: going up to somebody and pushing.

Source: Horswill 2008, "Grappling".
"""

from __future__ import annotations

from dataclasses import dataclass, field

from pipeline.simulation.characters.contact_tasks import PATIENCE
from pipeline.simulation.characters.encounter import Encounter, closing_pace
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import REACHING, SWINGING
from pipeline.simulation.characters.person_tasks import Approach, Task

SHOVE_RANGE = 0.5  # of who shoves from the middle of the other, in arm lengths
SHOVING_RATE = 3.0  # speed of the last steps to a shove, by the distance that is left [1/s]


@dataclass
class Grapple(Task):
    """Go to a character with both arms ahead.

    Attributes:
        owner: number of the character.
        time: since the arms came up [s].
        encounter: with it.
        approach: to it.
    """

    owner: int
    time: float = 0.0
    encounter: Encounter = field(default_factory=Encounter)
    approach: Approach = field(default_factory=Approach)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.time > PATIENCE:
            return True
        partner, stop = controller.view.pelvis(self.owner), SHOVE_RANGE * controller.arm
        share = self.encounter.share_of_way(controller, partner, stop, dt)
        reason = self.approach.walk_to(controller, partner, stop + share, self.owner, dt)
        distance = controller.ground_distance(partner)
        self.most_pace = closing_pace(controller, distance - stop - share, SHOVING_RATE)
        is_near = distance < 1.3 * controller.arm
        for k in range(2):
            if not controller.is_holding(k):
                controller.record.arm_mode[k] = REACHING if is_near else SWINGING
        if is_near:
            self.time += dt
        else:
            self.stick(reason, self.approach)
        if self.time > PATIENCE:
            controller.stop()
            for k in range(2):
                if not controller.is_holding(k):
                    controller.record.arm_mode[k] = SWINGING
        return self.time > PATIENCE
