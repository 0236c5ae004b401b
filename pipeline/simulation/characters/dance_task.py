"""Dance task: a standing person dances, guided by a torso like a dancer's."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from pipeline.simulation.characters.character_plans import proportions_of
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import HEAD, PELVIS
from pipeline.simulation.characters.person_tasks import POSTURE_PATIENCE, Task, place_text
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.people.guided_dance import (
    BodyStrike,
    DanceGuide,
    GuidedDance,
    strike_contact,
)
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.take import Contact
from pipeline.spec.character import Character
from pipeline.spec.script import Perform

GAZE_DISTANCE = 3.0
"""Of the place ahead of the head that a dancing person looks at [m]."""


@dataclass
class Dance(Task):
    """Come to stand and dance.

    Attributes:
        order: what to dance.
        guide: the dances of the person.
        time: in which it has come to stand [s].
        dance: under way; None before.
        ahead: (3,) direction in which the head faces, in the frame of the heading.
        strikes: of the last step.
    """

    order: Perform
    guide: DanceGuide
    time: float = 0.0
    dance: GuidedDance | None = None
    ahead: Array | None = None
    strikes: Sequence[BodyStrike] = field(default=())

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        self.strikes = ()
        person = controller.record
        if self.dance is None and not self._is_ready(controller, dt):
            return False
        if self.dance is None:
            self.dance = self.guide.begin(self.order)
            person.dance_step = dt
            self._write(controller, self.dance)
            person.dance_start[:] = person.dance_end
        if self.dance.is_over:
            return True
        if not person.frozen:
            self.strikes = self.dance.advance()
            self._write(controller, self.dance)
        person.dances = True
        return False

    def subject(self, controller: PersonController) -> Array | None:
        """See `Task`; the head faces where the dance turns it."""
        if self.ahead is None or self.dance is None or self.dance.is_over:
            return None
        person = controller.record
        turned = (heading(float(person.heading)) * self.ahead).sum(axis=1)
        place: Array = controller.view.p[person.node + HEAD] + GAZE_DISTANCE * turned
        return place

    def _is_ready(self, controller: PersonController, dt: float) -> bool:
        """Stop and rise; tell whether the person stands upright with empty hands."""
        held = [name for k in range(2) if (name := _held_name(controller, k))]
        if held:
            self.failure = f"holds '{held[0]}'; let go of it first"
            return False
        self.time += dt
        controller.stop()
        is_ready = controller.is_standing and controller.is_upright
        if not is_ready and self.time > POSTURE_PATIENCE:
            self.failure = f"cannot stand still at {place_text(controller)}"
        return is_ready

    def _write(self, controller: PersonController, dance: GuidedDance) -> None:
        pose, person = dance.pose(), controller.record
        person.dance_end[:], person.dance_arms[:] = pose.joints, pose.arms
        self.ahead = pose.ahead


def _held_name(controller: PersonController, k: int) -> str:
    """Return the name of what a hand holds, "" for nothing."""
    if k in controller.held_members:
        return controller.held_members[k]
    node, view = controller.held_node(k), controller.view
    return view.names[view.arrays.nodes["owner"][node]] if node >= 0 else ""


def rest_dances(persons: Records) -> None:
    """Let dances rest for a step, other than those whose tasks go on with them."""
    persons["dances"] = False
    persons["dance_start"] = persons["dance_end"]


def dance_contacts(
    dances: Iterable[tuple[PersonController, Dance]],
    cast: Sequence[Character],
    clothes: Mapping[str, Clothes],
    step: int,
) -> tuple[Contact, ...]:
    """Return the strikes of hands of people that dance, as contacts of a step."""
    found = list[Contact]()
    for controller, task in dances:
        if not task.strikes:
            continue
        person, name = controller.record, controller.name
        proportions = proportions_of(cast[int(person.owner)])
        assert proportions is not None
        pelvis = heading(float(person.heading)), person.targets[PELVIS].copy()
        found += [
            strike_contact(strike, name, proportions, clothes[name], step, pelvis)
            for strike in task.strikes
        ]
    return tuple(found)
