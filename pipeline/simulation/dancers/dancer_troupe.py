"""Dancer troupe: all dancers of a scene, each a simulated torso.

Source: Matarić, Zordan and Mason 1998.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dancers.dance_schedule import DanceSchedule
from pipeline.simulation.dancers.dancer_mesh import DancerAppearance, dancer_inventory, frame_links
from pipeline.simulation.dancers.dancer_motion import TOUCH_TOLERANCE, DancerMotion
from pipeline.simulation.dancers.dancer_poses import Place
from pipeline.simulation.dancers.dancer_script import ScriptedDancer
from pipeline.simulation.dancers.dancing_legs import DancingLegs, draw_style
from pipeline.simulation.dancers.hand_contacts import HandStrike
from pipeline.simulation.dancers.practice import measure_lateness
from pipeline.simulation.dancers.repertoire import SIDES, build_repertoire
from pipeline.simulation.dancers.torso import dancer_proportions
from pipeline.simulation.members import MemberState, members_named
from pipeline.simulation.order_outcome import Outcome
from pipeline.simulation.people.body_frames import FRAMES
from pipeline.simulation.people.face_tracker import FaceInputs, FaceTracker
from pipeline.simulation.people.guided_dance import BodyStrike, strike_contact
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import Facts, Troupe, World
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer
from pipeline.spec.expression import EMOTIONS
from pipeline.spec.script import Instruction, Perform, Reach

JOY = EMOTIONS.index("joy")


class DancerTroupe(Troupe):
    """All dancers of a scene.

    Raises:
        SceneError: if a place is out of reach, or tempo and durations conflict.
    """

    def __init__(
        self, cast: Sequence[tuple[int, Dancer]], dances: Mapping[str, Dance], world: World
    ) -> None:
        self.world, clock = world, world.clock
        self.members = [member for _, member in cast]
        self.R_WB = [heading(math.radians(member.heading_deg)) for member in self.members]
        self.p_WB = [_origin(member, world) for member in self.members]
        self.looks, self.directed = list[DancerAppearance](), list[ScriptedDancer]()
        for k, (i, member) in enumerate(cast):
            own = partial(_to_dancer_frame, self.R_WB[k], self.p_WB[k])
            proportions, path = dancer_proportions(member), f"cast[{i}]"
            orders = [(p, order.do) for p, order in world.instructions if order.who == member.name]
            repertoire = build_repertoire(
                member, proportions, dances, orders, world.directed, world.places, own, path
            )
            until = float(clock.time_of(clock.last_step))
            programme = DanceSchedule(member, repertoire, until, path)
            dancing = _practised_motion(member, programme, clock.dt)
            self.directed.append(ScriptedDancer(dancing, programme, own, clock.dt))
            clothes = world.clothes[member.name]
            drums = dict(repertoire.drums)
            self.looks.append(DancerAppearance(member.name, proportions, clothes, drums))
        self.dancing = [dancer.dancing for dancer in self.directed]
        torsos = [dancer.torso for dancer in self.dancing]
        self.inventory = dancer_inventory(self.looks, torsos, clock.rows)
        names = [member.name for member in self.members]
        self._faces = FaceTracker(names, world.seed, clock.row_time)
        self._links = frame_links()
        # Drums stand where the hands of a torso that stands still strike them.
        self._legs = [
            None
            if look.drums
            else DancingLegs(look.proportions, draw_style(generator(world.seed, f"{name}/legs")))
            for name, look in zip(names, self.looks, strict=True)
        ]
        self._rows: list[tuple[Array, Array, Array]] = []
        self._moods: list[FaceInputs] = []
        self._step, self._strikes = 0, list[tuple[int, HandStrike]]()
        self._arrived, self._outcomes = list[str](), list[Outcome]()

    def members_needed(self, orders: Orders) -> Collection[str]:
        """Returns the members that dancers look at."""
        named = members_named([member.name for member in self.members], orders)
        return named | {dancer.watched for dancer in self.directed if dancer.watched is not None}

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """Receives where the members are that dancers look at."""
        for dancer in self.directed:
            dancer.seen = members

    def read(self, orders: Orders) -> None:
        """Passes orders on to the dancers they name."""
        for member, dancer in zip(self.members, self.directed, strict=True):
            dancer.follow(orders.get(member.name, ()))

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Refuses instructions from outside that need places or drums unknown at the start."""
        do = instruction.do
        for member, dancer in zip(self.members, self.directed, strict=True):
            known = dancer.programme.repertoire
            if instruction.who != member.name:
                continue
            if isinstance(do, Reach) and any(
                (do.reach, side) not in known.reaches for side in SIDES[do.hand]
            ):
                message = "a dancer only reaches for places that the scene's script names"
                raise SceneError([Problem(f"{path}.do.reach", message)])
            if isinstance(do, Perform) and do.dance not in known.dances:
                message = (
                    f"the drums of '{do.dance}' exist only if the scene's script names the dance"
                )
                raise SceneError([Problem(f"{path}.do.dance", message)])

    def advance(self, step: int) -> None:
        """Advances all dancers by one step."""
        self._step = step
        for k, dancer in enumerate(self.directed):
            self._strikes += [(k, strike) for strike in dancer.dancing.advance()]
            if dancer.finish_bars():
                self._arrived.append(self.members[k].name)
            legs, dancing = self._legs[k], dancer.dancing
            if legs is not None:
                trunk = dancing.trunk
                # A held hand keeps its place in the world.
                sway = 0.0 if dancing.is_posed else trunk.sway
                now = dancing.now
                legs.advance(self.world.clock.dt, now - trunk.start, trunk.beat, sway)
            name = self.members[k].name
            self._outcomes += [Outcome(name, reach) for reach in dancer.finish_reaches()]

    def buffer_row(self) -> None:
        """Buffers the present state as the next row."""
        R, p, values = list[Array](), list[Array](), list[Array]()
        for k, (dancer, look) in enumerate(zip(self.dancing, self.looks, strict=True)):
            R_BL, p_BL = self._frames(k)
            still = np.broadcast_to(np.eye(3), (len(look.drums), 3, 3))
            tops = look.rest()[len(self._links) :]
            R_BN, p_BN = np.concatenate([R_BL, still]), np.concatenate([p_BL, tops])
            R_WB = self.R_WB[k]
            R.append((R_WB[None, :, :, None] * R_BN[:, None, :, :]).sum(axis=2))
            p.append(self.p_WB[k] + (p_BN[:, None, :] * R_WB).sum(axis=2))
            values += [dancer.moving.q.copy(), dancer.moving.torques()]
        self._rows.append((np.concatenate(R), np.concatenate(p), np.concatenate(values)))
        calm = FaceInputs.calm(len(self.directed))
        calm.felt[:, JOY] = [dancer.joy for dancer in self.directed]
        calm.told[:] = [dancer.told for dancer in self.directed]
        self._moods.append(calm)

    def write(self, rows: Rows) -> None:
        """Writes the buffered rows."""
        for k, (R, p, values) in enumerate(self._rows):
            rows.rotations[k], rows.positions[k], rows.values[k] = R, p, values
        rows.alive[:] = True
        rows.expressions[:] = self._faces.faces(self._moods)
        self._rows.clear()
        self._moods.clear()

    def facts(self) -> Facts:
        """Returns hand contacts of the last step, and who finished bars and reaches."""
        contacts = tuple(self._contact(k, strike) for k, strike in self._strikes)
        arrived, outcomes = tuple(self._arrived), tuple(self._outcomes)
        self._strikes.clear()
        self._arrived.clear()
        self._outcomes.clear()
        return Facts(contacts, arrived=arrived, outcomes=outcomes)

    def _frames(self, k: int) -> tuple[Array, Array]:
        """Returns rotations (15, 3, 3) and positions (15, 3) of the body frames."""
        R, p = self.dancing[k].moving.poses()
        turns, places = R[self._links], p[self._links]
        rest, fixed = self.looks[k].rest()[: len(self._links)], np.array(self._links) == 0
        places[fixed] = rest[fixed]
        legs = self._legs[k]
        if legs is None:
            return turns, places
        R_carried, t = legs.carry()
        turns = (R_carried[None, :, :, None] * turns[:, None, :, :]).sum(axis=2)
        places = (places[:, None, :] * R_carried).sum(axis=2) + t
        for name, (R_leg, place) in legs.legs().items():
            turns[FRAMES.index(name)], places[FRAMES.index(name)] = R_leg, place
        return turns, places

    def _contact(self, k: int, strike: HandStrike) -> Contact:
        look, dt = self.looks[k], self.world.clock.dt
        begin = self._step * dt
        R_WB, p_WB, legs = self.R_WB[k], self.p_WB[k], self._legs[k]
        if legs is not None:
            R, t = legs.carry()
            R_WB, p_WB = R_WB @ R, p_WB + R_WB @ t
        fraction = min(max((strike.time - begin) / dt, 0.0), math.nextafter(1.0, 0.0))
        contact = strike_contact(
            BodyStrike(
                *(fraction, strike.hand, strike.other, strike.place, strike.normal, strike.speed)
            ),
            *(self.members[k].name, look.proportions, look.clothes, self._step),
            (R_WB, p_WB),
        )
        drum = look.drums.get(strike.other)
        if drum is None:
            return contact
        return replace(contact, surface=drum.material, size=2.0 * drum.radius)


def _practised_motion(member: Dancer, programme: DanceSchedule, dt: float) -> DancerMotion:
    """Returns the motion of a dancer that has practised its dance."""
    repertoire, plan = programme.repertoire, programme.plan
    choreography = repertoire.choreography
    late = measure_lateness(member, choreography, plan.moves, plan.beat, dt)
    poses, hang = repertoire.poses, repertoire.hang
    return DancerMotion(
        *(member, choreography, plan.moves, plan.beat, dt, late),
        tolerance=TOUCH_TOLERANCE if late else 0.0,
        poses=poses,
        hang=hang,
    )


def _to_dancer_frame(R: Array, p: Array, place: Place) -> Place:
    """Returns a world position in the dancer's frame, with rotation R (3, 3) and origin p (3,)."""
    return _triple((R.T * (np.array(place) - p)).sum(axis=1))


def _origin(member: Dancer, world: World) -> Array:
    """Returns the origin of a dancer's frame (3,) [m]."""
    x, z = member.at
    floor = 0.0
    if member.parent is None:
        floor = float(world.ground.height(np.array(x), np.array(z)))
    return np.array([x, floor, z])


def _triple(v: Array) -> tuple[float, float, float]:
    x, y, z = v.tolist()
    return x, y, z
