"""RPC instruction: a script instruction that another program gives while a scene runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.errors import SceneError
from pipeline.spec.model_base import Fault
from pipeline.spec.name_references import faults_of_references
from pipeline.spec.renamed_keys import rename_keys
from pipeline.spec.scene import Scene
from pipeline.spec.script import Instruction
from pipeline.spec.validation import check, problems_of_faults
from pipeline.spec.yaml_tree import ListNode, MappingNode, tree_of


def instruction_of(values: Mapping[str, Any], scene: Scene, now: float) -> Instruction:
    """Return the instruction made of plain values, checked as the scene's own are.

    Args:
        values: such as `{"who": "bug", "do": {"go_to": [1, 2]}}`; with neither `at` nor `when`
            it is to be done at once.
        scene: to whose cast it is given.
        now: time of the scene [s].

    Raises:
        SceneError: something is wrong with it; holds every problem found.
    """
    if "at" not in values and "when" not in values:
        values = {"at": now, **values}
    around = tree_of({"script": (values,)})
    assert isinstance(around, MappingNode)
    script = rename_keys(around)[0].entries["script"].value
    assert isinstance(script, ListNode)
    (tree,) = script.items
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
    with_it = scene.model_copy(update={"script": (instruction,)})
    return [
        Fault(fault.path[2:], fault.message, fault.at_key)
        for fault in faults_of_references(with_it)
        if fault.path[:2] == ("script", 0)
    ]
