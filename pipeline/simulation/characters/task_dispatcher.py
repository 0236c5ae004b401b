"""Task dispatcher."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.contact_tasks import Grab, Grapple, Hug, Reach
from pipeline.simulation.characters.person_controller import (
    SIDES,
    CharacterView,
    PersonController,
    is_heavy,
)
from pipeline.simulation.characters.person_record import STANDING, SWINGING
from pipeline.simulation.characters.person_tasks import (
    PosedHands,
    Rise,
    SitDown,
    SitOn,
    Task,
    Turn,
    Walk,
)
from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.script import Orders
from pipeline.spec import script as words
from pipeline.spec.keyframes import PoseKey
from pipeline.spec.model_base import Target
from pipeline.spec.script import Do

STRAIGHT_ON = 1000.0
"""How far somebody goes who is told to walk and not where to [m]."""

LOOKS = (words.LookAt, words.LookAhead, words.SetSpeed, words.LetGo, words.SetUrges)
"""What is told beside what somebody does."""


class TaskDispatcher:
    """What all people of a troupe are told, and whether it is done.

    Args:
        view: all characters.
        persons: records of those who can be told something.
        dt: a step [s].
        poses: keys of their hands, by name.
    """

    def __init__(
        self,
        view: CharacterView,
        persons: Records,
        dt: float,
        poses: Mapping[str, Sequence[PoseKey]] | None = None,
    ) -> None:
        self.view = view
        self.dt = dt
        self.controllers = [
            PersonController(view.names[person.owner], person, view) for person in persons
        ]
        self._by_name = {controller.name: k for k, controller in enumerate(self.controllers)}
        self._errands: list[Task | None] = [None for _ in self.controllers]
        self._done = [True for _ in self.controllers]
        self._looks: list[Target | None] = [None for _ in self.controllers]
        self._arrived: list[str] = []
        self._told = [False for _ in self.controllers]
        self._glances = [NOBODY for _ in self.controllers]
        self.minded: frozenset[int] = frozenset()
        self._posing = {name: PosedHands(keys) for name, keys in (poses or {}).items() if keys}
        self._steps = 0

    def read(self, orders: Orders) -> None:
        """Take in what is asked of anybody from this step on."""
        for name, given in orders.items():
            if (k := self._by_name.get(name)) is not None:
                for do in given:
                    self._tell(k, do)

    def look_at(self, name: str, target: Target | None) -> None:
        """Let somebody look at something from now on; None is ahead."""
        self._looks[self._by_name[name]] = target

    # --- for those who have a mind of their own ---------------------------------------

    def is_told(self, k: int) -> bool:
        """Tell whether somebody does what a script has told it, and has not done it yet."""
        return self._told[k]

    def errand(self, k: int) -> Task | None:
        """Return what somebody does."""
        return self._errands[k]

    def begin(self, k: int, errand: Task) -> None:
        """Let somebody begin something by itself."""
        self.controllers[k].record.posture = STANDING
        self._begin(k, errand, keeps_arms=True)

    def end(self, k: int) -> None:
        """Let somebody leave off what it does; what hangs from its hands it keeps."""
        controller = self.controllers[k]
        controller.stop()
        controller.record.posture, controller.record.has_facing, controller.record.stoop_depth = (
            STANDING,
            False,
            0.0,
        )
        controller.part_hands()
        for hand in range(2):
            if controller.held(hand) < 0:
                controller.let_go(hand)
            else:
                controller.record.arm_mode[hand] = SWINGING
        self._errands[k], self._done[k] = None, True

    def glance(self, k: int, owner: int) -> None:
        """Let somebody look at a character, unless a script has told it where to look."""
        self._glances[k] = owner

    def before(self) -> None:
        """Command everybody for the step to come."""
        self._arrived.clear()
        time = self._steps * self.dt
        self._steps += 1
        for k, controller in enumerate(self.controllers):
            errand = self._errands[k]
            controller.forget_embrace()
            if errand is not None:
                done = errand.go_on(controller, self.dt)
                if done and not self._done[k]:
                    self._arrived.append(controller.name)
                self._done[k] = done or self._done[k]
                self._told[k] = self._told[k] and (not done or self._lasts(k))
            _carry(controller)
            if controller.name in self._posing:
                self._posing[controller.name].go_on(controller, time)
            self._look(k, controller)

    def arrived(self) -> tuple[str, ...]:
        """Return who has done what it was told, since the last step."""
        return tuple(self._arrived)

    def _lasts(self, k: int) -> bool:
        """Tell whether somebody stays as it was told until it is told something else."""
        return bool(self.controllers[k].record.frozen) or isinstance(
            self._errands[k], SitDown | SitOn
        )

    def _look(self, k: int, controller: PersonController) -> None:
        target = self._looks[k]
        whom = self._glances[k]
        if whom < 0:
            whom = getattr(self._errands[k], "owner", NOBODY)
        if isinstance(target, str):
            controller.look(self.view.face(self.view.number(target)))
        elif target is not None:
            controller.look(np.array(target))
        elif whom >= 0:
            controller.look(self.view.face(whom))
        else:
            controller.record.has_look_target = False

    def _tell(self, k: int, do: Do) -> None:
        controller = self.controllers[k]
        controller.record.frozen = do == "freeze"
        self._told[k] |= not isinstance(do, LOOKS)
        if do == "walk" and k in self.minded:
            # Its own mind says where to.
            self._told[k] = False
            self.end(k)
            return
        if isinstance(do, str):
            self._say(k, controller, do)
        elif isinstance(do, words.LookAt):
            self._looks[k] = do.look_at
        elif isinstance(do, words.LookAhead):
            self._looks[k] = None
        elif isinstance(do, words.SetSpeed):
            controller.record.pace = do.speed
        elif isinstance(do, words.Wait):
            controller.stop()
        elif isinstance(do, words.LetGo):
            self._let_go(k, SIDES[do.let_go])
        else:
            self._send(k, controller, do)

    def _say(self, k: int, controller: PersonController, do: str) -> None:
        """Do what one word says."""
        if do == "stop":
            controller.stop()
            self._begin(k, Walk())
        elif do == "walk":
            self._walk_on(k, controller)
        elif do == "sit":
            self._begin(k, SitDown())
        elif do == "stand":
            controller.stop()
            self._begin(k, Rise())
        elif do == "let_go":
            self._let_go(k, SIDES["both"])

    def _walk_on(self, k: int, controller: PersonController) -> None:
        """Go on to where somebody went, or straight on."""
        me = controller.record
        if isinstance(self._errands[k], Walk) and not self._done[k]:
            me.has_goal, me.posture = True, STANDING
            return
        controller.go(
            me.at[0] + STRAIGHT_ON * math.cos(me.heading),
            me.at[1] - STRAIGHT_ON * math.sin(me.heading),
        )
        self._begin(k, Walk())

    def _send(self, k: int, controller: PersonController, do: Do) -> None:
        """Do what takes a while."""
        controller.record.posture = STANDING
        if isinstance(do, words.GoTo):
            controller.go(*do.go_to)
            self._begin(k, Walk(np.array(do.go_to, dtype=float)), keeps_arms=True)
        elif isinstance(do, words.TurnBy):
            controller.turn_to(float(controller.record.heading) + math.radians(do.turn_deg))
            self._begin(k, Turn(), keeps_arms=True)
        elif isinstance(do, words.Reach):
            place = None if isinstance(do.reach, str) else np.array(do.reach)
            whom = self.view.number(do.reach) if isinstance(do.reach, str) else NOBODY
            self._begin(k, Reach(SIDES[do.hand], place, whom), keeps_arms=True)
        elif isinstance(do, words.Grab):
            number = self.view.number(do.grab)
            self._begin(k, Grab(SIDES[do.hand], number, do.part), keeps_arms=True)
        elif isinstance(do, words.Hug):
            number = self.view.number(do.hug)
            self._begin(k, Hug(number, self.view.size(number)))
        elif isinstance(do, words.Grapple):
            self._begin(k, Grapple(self.view.number(do.grapple)))
        elif isinstance(do, words.SitOn):
            self._begin(k, SitOn(self.view.number(do.sit)))

    def _begin(self, k: int, errand: Task, keeps_arms: bool = False) -> None:
        """Begin something; arms that do not hold anything hang again, unless they are kept."""
        controller, before = self.controllers[k], self._errands[k]
        keeps_arms = keeps_arms and (self._done[k] or not isinstance(before, Grab))
        self._errands[k], self._done[k] = errand, False
        controller.record.stoop_depth = 0.0
        controller.part_hands()
        for hand in range(2):
            if not keeps_arms and controller.held(hand) < 0:
                controller.record.arm_mode[hand] = SWINGING

    def _let_go(self, k: int, hands: Sequence[int]) -> None:
        self.controllers[k].part_hands()
        for hand in hands:
            self.controllers[k].let_go(hand)
        if isinstance(self._errands[k], Hug | Reach | Grab | Grapple):
            self.controllers[k].stop()
            self.controllers[k].record.has_facing = False
            self.controllers[k].record.stoop_depth = 0.0
            self._errands[k] = None


def _carry(controller: PersonController) -> None:
    """Let what is light hang from the hand, and the hand go along with what is heavy."""
    nodes = controller.view.arrays.nodes
    for k in range(2):
        node = controller.held(k)
        if node >= 0 and is_heavy(controller, int(nodes["owner"][node])):
            controller.put_hand(k, nodes["p"][node])
        elif node >= 0:
            controller.record.arm_mode[k] = SWINGING
