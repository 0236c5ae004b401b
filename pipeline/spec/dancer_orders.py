"""Dancer orders: what a dancer can be told and posed in, and what of it cannot be."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from pipeline.spec.dance import ARM_JOINTS, TRUNK_JOINTS
from pipeline.spec.faults import Fault, Step
from pipeline.spec.nearest import hint
from pipeline.spec.pose import PoseKey

DANCERS_ALONE = ("dance",)
"""What only dancers are told."""

TOLD = ("dance", "stop", "freeze", "wait", "reach", "let_go", "look_at", "look")
"""What a dancer can be told."""

ARMS = {"arm_r": "r", "hand_r": "r", "arm_l": "l", "hand_l": "l"}
"""Limbs and nodes of a dancer that are posed, and the side that they are on."""

TRUNK = "trunk"
"""What waist and neck are called when they are released."""

SIDED = tuple(
    f"{joint.split('_')[0]}_{side}_{joint.split('_')[1]}" for side in "rl" for joint in ARM_JOINTS
)

POSED_JOINTS = tuple(f"{joint}_deg" for joint in (*SIDED, *TRUNK_JOINTS))
"""Joints of a dancer, as they are posed."""

Path = tuple[Step, ...]


def faults_of_orders(
    name: str, do: object, path: Path, dances: Collection[str], hangs: bool = False
) -> Iterator[Fault]:
    """Find what a dancer is told that it cannot do.

    Args:
        name: of the dancer.
        do: what it is told, typed or raw.
        path: of that.
        dances: names of those that the scene has.
        hangs: whether the dancer goes along with a parent.
    """
    words = [do] if isinstance(do, str) else sorted(_given(do))
    word = next(iter(words), None)
    if word is not None and not {*words} & {*TOLD}:
        message = f"'{name}' is a dancer, who can be told {', '.join(TOLD)}"
        yield Fault(path if isinstance(do, str) else (*path, word), message, at_key=word != do)
        return
    dance = _get(do, "dance")
    if isinstance(dance, str) and dance not in dances:
        yield Fault((*path, "dance"), f"no dance is called '{dance}', {hint(dance, dances)}")
    for key in ("look_at", "reach"):
        thing = _get(do, key)
        if isinstance(thing, str):
            message = f"a dancer follows nobody; give the place of '{thing}', [x, y, z]"
            yield Fault((*path, key), message)
        elif thing is not None and hangs:
            message = f"'{name}' goes along with its parent, and places are the world's"
            yield Fault((*path, key), message, at_key=True)


def faults_of_posing(keys: Sequence[PoseKey], hangs: bool) -> Iterator[Fault]:
    """Find what is asked of a dancer's limbs and joints that it has not, or cannot do.

    Args:
        keys: its pose.
        hangs: whether it goes along with a parent.
    """
    for k, key in enumerate(keys):
        path: Path = ("pose", k)
        yield from _faults_of_limbs(key, path)
        if key.frame == "world" and hangs:
            message = "who goes along with a parent is posed in feet or body"
            yield Fault((*path, "frame"), message)
        for joint in key.joints or ():
            if joint not in POSED_JOINTS:
                message = f"no joint of a dancer is called so, {hint(joint, POSED_JOINTS)}"
                yield Fault((*path, "joints", joint), message, at_key=True)
        yield from _faults_of_sides(key, path)


def _faults_of_limbs(key: PoseKey, path: Path) -> Iterator[Fault]:
    """Find what a dancer's arms are asked for that they cannot do, and limbs that it has not."""
    for word in ("aim", "turn_deg", "body", "priority", "weight", "ease"):
        # What is written out in full has the ordinary values as well.
        if getattr(key, word) != PoseKey.model_fields[word].default:
            message = "of a dancer give reach or joints, or release; take this away"
            yield Fault((*path, word), message, at_key=True)
    for word in ("limb", "node"):
        limb = getattr(key, word)
        if limb is not None and limb not in ARMS:
            yield Fault((*path, word), f"a dancer has arms alone, {hint(limb, ARMS)}")
    released = (*ARMS, TRUNK)
    if key.release is None:
        return
    if key.release not in released:
        message = f"nothing of a dancer is called '{key.release}', {hint(key.release, released)}"
        yield Fault((*path, "release"), message)
    elif key.reach is not None or key.joints:
        message = "what is released is not posed at once; give another key"
        yield Fault((*path, "release"), message, at_key=True)


def _faults_of_sides(key: PoseKey, path: Path) -> Iterator[Fault]:
    """Find joints of the other arm beside a place: one key is for one arm then."""
    side = ARMS.get(key.limb or key.node or "")
    for joint in key.joints or ():
        if side is not None and joint in POSED_JOINTS and side_of(joint) not in (side, ""):
            message = "is of the other arm than the one that reaches; give it a key of its own"
            yield Fault((*path, "joints", joint), message, at_key=True)


def side_of(joint: str) -> str:
    """Return the side that a posed joint is on, "" for waist and neck."""
    parts = joint.split("_")
    return parts[1] if parts[1] in ("r", "l") else ""


def _given(words: object) -> set[str]:
    if isinstance(words, Mapping):
        return {key for key in words if isinstance(key, str)}
    return set(words.model_fields_set) if isinstance(words, BaseModel) else set()


def _get(thing: object, key: str) -> Any:
    if isinstance(thing, Mapping):
        return thing.get(key)
    return getattr(thing, key, None) if isinstance(thing, BaseModel) else None
