"""Telling: an instruction that is given to a scene from outside, as plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.errors import SceneError
from pipeline.spec.checking import check, problems_of_faults
from pipeline.spec.faults import Fault
from pipeline.spec.references import faults_of_references
from pipeline.spec.scene import Scene
from pipeline.spec.script import Instruction
from pipeline.spec.tree import Entry, Leaf, Place, Row, Table, Tree

PLACE = Place("")
"""Words from outside stand in no file."""


def instruction_of(words: Mapping[str, Any], scene: Scene, now: float) -> Instruction:
    """Return the instruction that plain words stand for, checked as the scene's own are.

    Args:
        words: such as `{"who": "bug", "do": {"go_to": [1, 2]}}`; with neither `at` nor `when`
            it is to be done at once.
        scene: to whose cast it is given.
        now: time of the scene [s].

    Raises:
        SceneError: something is wrong with it; holds every problem found.
    """
    if "at" not in words and "when" not in words:
        words = {"at": now, **words}
    tree = tree_of(words)
    instruction, problems = check(Instruction, tree)
    if instruction is None:
        raise SceneError(problems)
    faults = [*_faults_of_time(instruction, scene, now), *_faults_of_names(instruction, scene)]
    if faults:
        raise SceneError(problems_of_faults(tree, faults))
    return instruction


def _faults_of_time(instruction: Instruction, scene: Scene, now: float) -> Sequence[Fault]:
    if instruction.at is None:
        return []
    end = float(scene.n_frames / scene.rate)
    if instruction.at < now:
        return [Fault(("at",), f"is over: the scene is at {now:.4g} s; leave it out for now")]
    if instruction.at >= end:
        return [Fault(("at",), f"never comes: the scene ends at {end:.4g} s")]
    return []


def _faults_of_names(instruction: Instruction, scene: Scene) -> Sequence[Fault]:
    asked = scene.model_copy(update={"script": (instruction,)})
    return [
        Fault(fault.path[2:], fault.message, fault.at_key)
        for fault in faults_of_references(asked)
        if fault.path[:2] == ("script", 0)
    ]


def tree_of(words: Any) -> Tree:
    """Return plain words as a tree, which stands nowhere."""
    if isinstance(words, Mapping):
        return Table(PLACE, {key: Entry(PLACE, tree_of(one)) for key, one in words.items()})
    if isinstance(words, list | tuple):
        return Row(PLACE, tuple(tree_of(one) for one in words))
    return Leaf(PLACE, words)
