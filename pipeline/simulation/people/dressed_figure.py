"""Dressed figure: a clothed person's meshes on the links of a figure that is drawn as a person.

The person gets the lengths of the figure's bones, so that its joints lie on the figure's. What its
frames move is laid along the links as the figure stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_skin import has_face, skin_form
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.network import ARM, HEAD, LEG
from pipeline.simulation.figures.skeleton import Limb, Link
from pipeline.simulation.people.body_frames import FRAMES, frame_origins
from pipeline.simulation.people.person_mesh import MaterialLayer, person_layers
from pipeline.simulation.people.proportions import ADULT, Proportions
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.spatial import Array, cross, normalized

PERSON_HINT = "write `skin: {form: person}` in a figure drawn as a person"

LIMB_FRAMES = {ARM: ("upper_arm", "forearm", "hand"), LEG: ("thigh", "shin", "foot")}
"""Frames of the three links of a limb, from its root."""

HEAD_SIZE = 1.1
"""Height of a head, chin to crown, in the distance of its crown from the joint below."""

TOE_REACH = 0.68
"""Distance of the toes ahead of the ankle, in the length of a shoe."""

SOLE = 0.008
"""By which soles are drawn above the ground, into which rolling feet would press them [m]."""

LEAST_HEAD = 0.10
"""Least height of a head, in that of a person."""


@dataclass(frozen=True, eq=False)
class PersonBones:
    """The figure's bones as a person's.

    Attributes:
        proportions: of the person.
        links: (15,) link that moves each frame.
        turns: (15, 3, 3) rotation of each frame from the person's rest to the figure's.
        places: (15, 3) joint of each frame in the figure's rest pose [m].
    """

    proportions: Proportions
    links: NDArray[np.int64]
    turns: Array
    places: Array


_BONES: WeakKeyDictionary[Figure, PersonBones] = WeakKeyDictionary()
_LAYERS: WeakKeyDictionary[Figure, dict[Clothes, tuple[MaterialLayer, ...]]] = WeakKeyDictionary()


def is_person(figure: Figure) -> bool:
    """Return whether a figure is seen as a dressed person."""
    return skin_form(figure) == "person"


def check_person(figure: Figure) -> None:
    """Refuse the skin of a person on a figure that is not drawn as one.

    Raises:
        SceneError: limbs are missing, or are too many, or have another number of links.
    """
    if not is_person(figure):
        return
    counts = sorted((limb.kind, limb.side, len(limb.links)) for limb in figure.skeleton.limbs)
    expected = [(ARM, "l", 3), (ARM, "r", 3), (HEAD, "m", 2), (LEG, "l", 3), (LEG, "r", 3)]
    if counts == sorted(expected) and has_face(
        figure.skeleton.links[_limb(figure, HEAD, "m").links[-1]]
    ):
        return
    message = (
        "a person has two legs and two arms of three links each, an upright neck and head of two, "
        "and nothing else; draw it so, or write `form: plain`"
    )
    raise SceneError([Problem(f"figures.{figure.name}.skin.form", message)])


def figure_layers(figure: Figure, clothes: Clothes) -> tuple[MaterialLayer, ...]:
    """Return the layers of a clothed person on a figure, following its links by their numbers.

    No layer follows one link alone, so that none counts as a solid of the figure.
    """
    known = _LAYERS.setdefault(figure, {})
    if clothes not in known:
        bones = person_bones(figure)
        layers = person_layers(bones.proportions, clothes)
        known[clothes] = tuple(_on_links(layer, bones) for layer in layers)
    return known[clothes]


def _on_links(layer: MaterialLayer, bones: PersonBones) -> MaterialLayer:
    mesh = layer.mesh
    rest = frame_origins(bones.proportions)
    offset = mesh.vertices[:, None, :].astype(float) - rest[mesh.nodes]
    turned = (bones.turns[mesh.nodes] * offset[:, :, None, :]).sum(axis=-1)
    weights = mesh.weights.astype(float)[:, :, None]
    places = ((turned + bones.places[mesh.nodes]) * weights).sum(axis=1)
    nodes = bones.links[mesh.nodes].astype(np.int32)
    alone = nodes[:, 0] == nodes[:, 1]
    weights = mesh.weights.copy()
    weights[alone] = [1.0, 0.0]
    nodes[alone, 1] = np.where(nodes[alone, 0] == 0, bones.links[FRAMES.index("head")], 0)
    # Hair, creases, twists, and what faces and hands move, turn with the frame that a vertex
    # follows most.
    own = bones.turns[mesh.nodes[np.arange(len(nodes)), mesh.weights.argmax(axis=1)]]
    hair, offsets, creases, twists = mesh.hair, mesh.offsets, mesh.creases, mesh.twists
    if len(hair):
        hair = (own * hair[:, None, :].astype(float)).sum(axis=-1).astype(np.float32)
    if len(offsets):
        by_frame = own[mesh.targets[:, 0]]
        offsets = (by_frame * offsets[:, None, :].astype(float)).sum(axis=-1).astype(np.float32)
    if len(creases):
        creases = (own * creases[:, None, :].astype(float)).sum(axis=-1).astype(np.float32)
        # Their second node stands for none, whatever its bend.
        creases[alone] = 0.0
    if len(twists):
        twists = (own * twists[:, None, :].astype(float)).sum(axis=-1).astype(np.float32)
        twists[alone] = 0.0
    moved = replace(
        mesh,
        vertices=places.astype(np.float32),
        nodes=nodes,
        weights=weights,
        hair=hair,
        offsets=offsets,
        creases=creases,
        twists=twists,
    )
    for array in (moved.vertices, moved.nodes, moved.weights, hair, offsets, creases, twists):
        array.setflags(write=False)
    return replace(layer, mesh=moved)


def hand_links(figure: Figure) -> tuple[str, str]:
    """Return the names of the links of a person's left and right hand."""
    left, right = (
        figure.skeleton.links[int(person_bones(figure).links[FRAMES.index(name)])].name
        for name in ("hand_l", "hand_r")
    )
    return left, right


def person_bones(figure: Figure) -> PersonBones:
    """Return the bones of a figure that `check_person` accepts, as a person's."""
    if figure not in _BONES:
        _BONES[figure] = _measured(figure)
    return _BONES[figure]


def _measured(figure: Figure) -> PersonBones:
    """Return the bones of a figure that `check_person` accepts."""
    joints = {
        (kind, side): _joints(figure, _limb(figure, kind, side))
        for kind in (ARM, LEG)
        for side in "lr"
    }
    preferred = JointTree.of(figure.skeleton).pose(figure.skeleton.preferred)
    head = _limb(figure, HEAD, "m").links[-1]
    neck = figure.skeleton.links[head]
    hips = 0.5 * (joints[LEG, "l"][0] + joints[LEG, "r"][0])
    foot = figure.skeleton.links[_limb(figure, LEG, "r").links[-1]]
    toe = (preferred[foot.joint, :3, :3] * (foot.ends[1] - foot.ends[0])).sum(axis=-1)
    sole = np.array([toe[0] + foot.radii[1], foot.radii[1] - toe[1] - SOLE])
    proportions = _proportions(joints[LEG, "r"], joints[ARM, "r"], hips, neck, sole)
    rest = frame_origins(proportions)
    links, turns = np.zeros(len(FRAMES), dtype=np.int64), np.tile(np.eye(3), (len(FRAMES), 1, 1))
    places = rest + hips - rest[FRAMES.index("pelvis")]
    links[FRAMES.index("head")] = head
    for (kind, side), points in joints.items():
        for k, name in enumerate(LIMB_FRAMES[kind]):
            frame = FRAMES.index(f"{name}_{side}")
            links[frame] = _limb(figure, kind, side).links[k]
            places[frame] = points[k]
            if name == "foot":
                # Its sole is level in the preferred pose.
                turns[frame] = preferred[figure.skeleton.links[links[frame]].joint, :3, :3].T
            else:
                turns[frame] = _hanging(points[k + 1] - points[k])
    return PersonBones(proportions, links, turns, places)


def _proportions(leg: Array, arm: Array, hips: Array, neck: Link, sole: Array) -> Proportions:
    """Return the proportions of a person with a figure's bones.

    Args:
        leg: (4, 3) joints of the right leg and its tip [m].
        arm: (4, 3) joints of the right arm and its fingertips [m].
        hips: (3,) between the hips [m].
        neck: the link of the head.
        sole: (2,) reach of the toes ahead of the ankle, and height of the ankle above them [m].
    """
    reach, ankle = sole.tolist()
    shin, thigh = (float(np.linalg.norm(leg[k + 1] - leg[k])) for k in (1, 0))
    upper_arm, forearm, hand = (float(np.linalg.norm(arm[k + 1] - arm[k])) for k in range(3))
    hip = ankle + shin + thigh
    height = hip + float(neck.ends[1, 1] - hips[1]) + neck.radii[1]
    shoulder = hip + float(arm[0, 1] - hips[1])
    head = HEAD_SIZE * (float(neck.ends[1, 1] - neck.ends[0, 1]) + neck.radii[1])
    head = float(np.clip(head, LEAST_HEAD * height, 0.92 * (height - shoulder)))
    along_back = (ADULT.spine - ADULT.hip) / (ADULT.shoulder - ADULT.hip)
    return Proportions(
        height=height,
        mass=ADULT.mass * (height / ADULT.height) ** 3,
        ankle=ankle / height,
        knee=(ankle + shin) / height,
        hip=hip / height,
        spine=(hip + along_back * (shoulder - hip)) / height,
        shoulder=shoulder / height,
        head=1.0 - 0.54 * head / height,
        hips=float(leg[0, 2]) / height,
        shoulders=float(arm[0, 2]) / height,
        upper_arm=upper_arm / height,
        forearm=forearm / height,
        hand=hand / height,
        foot=reach / TOE_REACH / height,
        head_size=head / height,
    )


def _limb(figure: Figure, kind: str, side: str) -> Limb:
    return next(x for x in figure.skeleton.limbs if (x.kind, x.side) == (kind, side))


def _joints(figure: Figure, limb: Limb) -> Array:
    """Return the joints of a limb and its tip (links + 1, 3) [m]."""
    ends = [figure.skeleton.links[i].ends for i in limb.links]
    return np.array([*(span[0] for span in ends), ends[-1][1]])


def _hanging(along: Array) -> Array:
    """Return the frame (3, 3) of a bone along a direction (3,), nearest to the figure's."""
    y = -normalized(along)
    z = normalized(np.array([0.0, 0.0, 1.0]) - y[2] * y)
    return np.stack([cross(y, z), y, z], axis=-1)
