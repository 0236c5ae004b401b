"""Task dispatcher."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.contact_tasks import Grab, Grapple, Hug, Reach
from pipeline.simulation.characters.person_controller import SIDES, Actor, Stage, is_heavy
from pipeline.simulation.characters.person_record import STANDING, SWINGING
from pipeline.simulation.characters.person_tasks import (
    Posing,
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
from pipeline.spec.pose import PoseKey
from pipeline.spec.script import Do
from pipeline.spec.values import Target

STRAIGHT_ON = 1000.0
"""How far somebody goes who is told to walk and not where to [m]."""

LOOKS = (words.LookAt, words.LookAhead, words.SetSpeed, words.LetGo, words.SetUrges)
"""What is told beside what somebody does."""


class Direction:
    """What all people of a troupe are told, and whether it is done.

    Args:
        stage: all characters.
        persons: records of those who can be told something.
        dt: a step [s].
        poses: keys of their hands, by name.
    """

    def __init__(
        self,
        stage: Stage,
        persons: Records,
        dt: float,
        poses: Mapping[str, Sequence[PoseKey]] | None = None,
    ) -> None:
        self.stage = stage
        self.dt = dt
        self.actors = [Actor(stage.names[person.owner], person, stage) for person in persons]
        self._by_name = {actor.name: k for k, actor in enumerate(self.actors)}
        self._errands: list[Task | None] = [None for _ in self.actors]
        self._done = [True for _ in self.actors]
        self._looks: list[Target | None] = [None for _ in self.actors]
        self._arrived: list[str] = []
        self._told = [False for _ in self.actors]
        self._glances = [NOBODY for _ in self.actors]
        self.minded: frozenset[int] = frozenset()
        self._posing = {name: Posing(keys) for name, keys in (poses or {}).items() if keys}
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
        self.actors[k].me.posture = STANDING
        self._begin(k, errand, keeps_arms=True)

    def end(self, k: int) -> None:
        """Let somebody leave off what it does; what hangs from its hands it keeps."""
        actor = self.actors[k]
        actor.stop()
        actor.me.posture, actor.me.faces, actor.me.down = STANDING, False, 0.0
        actor.part_hands()
        for hand in range(2):
            if actor.held(hand) < 0:
                actor.let_go(hand)
            else:
                actor.me.arm[hand] = SWINGING
        self._errands[k], self._done[k] = None, True

    def glance(self, k: int, owner: int) -> None:
        """Let somebody look at a character, unless a script has told it where to look."""
        self._glances[k] = owner

    def before(self) -> None:
        """Command everybody for the step to come."""
        self._arrived.clear()
        time = self._steps * self.dt
        self._steps += 1
        for k, actor in enumerate(self.actors):
            errand = self._errands[k]
            actor.forget_embrace()
            if errand is not None:
                done = errand.go_on(actor, self.dt)
                if done and not self._done[k]:
                    self._arrived.append(actor.name)
                self._done[k] = done or self._done[k]
                self._told[k] = self._told[k] and (not done or self._lasts(k))
            _carry(actor)
            if actor.name in self._posing:
                self._posing[actor.name].go_on(actor, time)
            self._look(k, actor)

    def arrived(self) -> tuple[str, ...]:
        """Return who has done what it was told, since the last step."""
        return tuple(self._arrived)

    def _lasts(self, k: int) -> bool:
        """Tell whether somebody stays as it was told until it is told something else."""
        return bool(self.actors[k].me.frozen) or isinstance(self._errands[k], SitDown | SitOn)

    def _look(self, k: int, actor: Actor) -> None:
        target = self._looks[k]
        whom = self._glances[k]
        if whom < 0:
            whom = getattr(self._errands[k], "owner", NOBODY)
        if isinstance(target, str):
            actor.look(self.stage.face(self.stage.number(target)))
        elif target is not None:
            actor.look(np.array(target))
        elif whom >= 0:
            actor.look(self.stage.face(whom))
        else:
            actor.me.looks = False

    def _tell(self, k: int, do: Do) -> None:
        actor = self.actors[k]
        actor.me.frozen = do == "freeze"
        self._told[k] |= not isinstance(do, LOOKS)
        if do == "walk" and k in self.minded:
            # Its own mind says where to.
            self._told[k] = False
            self.end(k)
            return
        if isinstance(do, str):
            self._say(k, actor, do)
        elif isinstance(do, words.LookAt):
            self._looks[k] = do.look_at
        elif isinstance(do, words.LookAhead):
            self._looks[k] = None
        elif isinstance(do, words.SetSpeed):
            actor.me.pace = do.speed
        elif isinstance(do, words.Wait):
            actor.stop()
        elif isinstance(do, words.LetGo):
            self._let_go(k, SIDES[do.let_go])
        else:
            self._send(k, actor, do)

    def _say(self, k: int, actor: Actor, do: str) -> None:
        """Do what one word says."""
        if do == "stop":
            actor.stop()
            self._begin(k, Walk())
        elif do == "walk":
            self._walk_on(k, actor)
        elif do == "sit":
            self._begin(k, SitDown())
        elif do == "stand":
            actor.stop()
            self._begin(k, Rise())
        elif do == "let_go":
            self._let_go(k, SIDES["both"])

    def _walk_on(self, k: int, actor: Actor) -> None:
        """Go on to where somebody went, or straight on."""
        me = actor.me
        if isinstance(self._errands[k], Walk) and not self._done[k]:
            me.goes, me.posture = True, STANDING
            return
        actor.go(
            me.at[0] + STRAIGHT_ON * math.cos(me.heading),
            me.at[1] - STRAIGHT_ON * math.sin(me.heading),
        )
        self._begin(k, Walk())

    def _send(self, k: int, actor: Actor, do: Do) -> None:
        """Do what takes a while."""
        actor.me.posture = STANDING
        if isinstance(do, words.GoTo):
            actor.go(*do.go_to)
            self._begin(k, Walk(np.array(do.go_to, dtype=float)), keeps_arms=True)
        elif isinstance(do, words.TurnBy):
            actor.turn_to(float(actor.me.heading) + math.radians(do.turn_deg))
            self._begin(k, Turn(), keeps_arms=True)
        elif isinstance(do, words.Reach):
            place = None if isinstance(do.reach, str) else np.array(do.reach)
            whom = self.stage.number(do.reach) if isinstance(do.reach, str) else NOBODY
            self._begin(k, Reach(SIDES[do.hand], place, whom), keeps_arms=True)
        elif isinstance(do, words.Grab):
            number = self.stage.number(do.grab)
            self._begin(k, Grab(SIDES[do.hand], number, do.part), keeps_arms=True)
        elif isinstance(do, words.Hug):
            number = self.stage.number(do.hug)
            self._begin(k, Hug(number, self.stage.size(number)))
        elif isinstance(do, words.Grapple):
            self._begin(k, Grapple(self.stage.number(do.grapple)))
        elif isinstance(do, words.SitOn):
            self._begin(k, SitOn(self.stage.number(do.sit)))

    def _begin(self, k: int, errand: Task, keeps_arms: bool = False) -> None:
        """Begin something; arms that do not hold anything hang again, unless they are kept."""
        actor, before = self.actors[k], self._errands[k]
        keeps_arms = keeps_arms and (self._done[k] or not isinstance(before, Grab))
        self._errands[k], self._done[k] = errand, False
        actor.me.down = 0.0
        actor.part_hands()
        for hand in range(2):
            if not keeps_arms and actor.held(hand) < 0:
                actor.me.arm[hand] = SWINGING

    def _let_go(self, k: int, hands: Sequence[int]) -> None:
        self.actors[k].part_hands()
        for hand in hands:
            self.actors[k].let_go(hand)
        if isinstance(self._errands[k], Hug | Reach | Grab | Grapple):
            self.actors[k].stop()
            self.actors[k].me.faces = False
            self.actors[k].me.down = 0.0
            self._errands[k] = None


def _carry(actor: Actor) -> None:
    """Let what is light hang from the hand, and the hand go along with what is heavy."""
    nodes = actor.stage.crowd.nodes
    for k in range(2):
        node = actor.held(k)
        if node >= 0 and is_heavy(actor, int(nodes["owner"][node])):
            actor.put_hand(k, nodes["p"][node])
        elif node >= 0:
            actor.me.arm[k] = SWINGING
