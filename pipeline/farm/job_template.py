"""Job template: films as steps of Open Job Description, for farms that have a manager of their own.

Source: Open Job Description, template schemas 2023-09, with the extension TASK_CHUNKING.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import StoreError
from pipeline.farm.worker_needs import WorkerNeeds
from pipeline.production.run.film_source import split_frames
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.production.run.order import Order
from pipeline.spec import library

CHUNK_SECONDS = 300
"""Time that a task should take, once its manager has measured some [s]."""

FIRST_CHUNK = 8
"""Frames of a task before that."""

MAX_STEP_NAME = 64
"""Of a step, by the specification [characters]."""

Members = dict[str, Any]


@dataclass(frozen=True, slots=True)
class JobScene:
    """A scene of a job.

    Attributes:
        order: of its film.
        file: of the scene, relative to the template; None for a shipped scene.
        options: of the command line that change the scene.
    """

    order: Order
    file: str | None
    options: tuple[str, ...]


def job_template(scenes: Sequence[JobScene]) -> str:
    """Return the template of a job that simulates, renders, encodes and assembles films.

    Workers need pronk in the same version, and the store; the files that a scene names stand beside
    it or travel as attachments of the job.
    """
    names = [scene.order.name for scene in scenes]
    template: Members = {
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": f"pronk {names[0]}" + (f" and {len(names) - 1} more" if len(names) > 1 else ""),
        "parameterDefinitions": [
            {
                "name": "Store",
                "type": "STRING",
                "description": "Where takes and frames are: a shared folder, s3://bucket/folder.",
                "minLength": 1,
            },
            {
                "name": "Out",
                "type": "PATH",
                "objectType": "DIRECTORY",
                "dataFlow": "OUT",
                "default": "out",
                "description": "Folder for the output folders of scenes.",
            },
            {
                "name": "Pronk",
                "type": "STRING",
                "default": "pronk",
                "description": "The command.",
            },
            *(_scene_parameter(scene, n) for n, scene in enumerate(scenes, 1) if scene.file),
        ],
        "steps": [step for n, scene in enumerate(scenes, 1) for step in _steps(scene, n)],
    }
    return yaml.safe_dump(template, sort_keys=False, allow_unicode=True, width=100)


def _scene_parameter(scene: JobScene, number: int) -> Members:
    return {
        "name": f"Scene{number}",
        "type": "PATH",
        "objectType": "FILE",
        "dataFlow": "IN",
        "default": scene.file,
        "description": f"The scene {scene.order.name}.",
    }


def _steps(scene: JobScene, number: int) -> list[Members]:
    """Return the steps of one film; each begins when all tasks of the one before have ended."""
    order, film = scene.order, scene.order.scene
    simulate, render, encode, assemble = (
        _step_name(verb, order.name, number)
        for verb in ("Simulate", "Render", "Encode", "Assemble")
    )
    needs = WorkerNeeds.of(film).requirements
    chosen = ["--frames", order.frames] if order.frames else []
    segments = len(split_frames(parse_frames(order.frames, film.n_frames), film.rate))
    encoding: Members = {
        "name": encode,
        "dependencies": [{"dependsOn": render}],
        "hostRequirements": needs,
        "parameterSpace": {
            "taskParameterDefinitions": [
                {"name": "Segment", "type": "INT", "range": f"1-{segments}"}
            ]
        },
        "script": _script(
            *(scene, number, "encode"),
            [*chosen, "--shard", f"{{{{Task.Param.Segment}}}}/{segments}"],
        ),
    }
    return [
        {
            "name": simulate,
            "hostRequirements": needs,
            "script": _script(scene, number, "simulate", []),
        },
        {
            "name": render,
            "dependencies": [{"dependsOn": simulate}],
            "hostRequirements": needs,
            "parameterSpace": {
                "taskParameterDefinitions": [
                    {
                        "name": "Frame",
                        "type": "CHUNK[INT]",
                        "range": order.frames or f"1-{film.n_frames}",
                        "chunks": {
                            "defaultTaskCount": min(FIRST_CHUNK, film.n_frames),
                            "targetRuntimeSeconds": CHUNK_SECONDS,
                            "rangeConstraint": "CONTIGUOUS",
                        },
                    }
                ]
            },
            "script": _script(scene, number, "frames", ["--frames", "{{Task.Param.Frame}}"]),
        },
        *([encoding] if segments > 1 else []),
        {
            "name": assemble,
            "dependencies": [{"dependsOn": encode if segments > 1 else render}],
            "hostRequirements": needs,
            "script": _script(
                scene,
                number,
                "assemble",
                [
                    *("--out", "{{Param.Out}}"),
                    *chosen,
                    *([] if order.sound else ["--no-sound"]),
                ],
            ),
        },
    ]


def _script(scene: JobScene, number: int, verb: str, more: Sequence[str]) -> Members:
    name = f"{{{{Param.Scene{number}}}}}" if scene.file else scene.order.name
    backend = scene.order.backend
    options = [*scene.options, *(["--backend", backend] if backend != "auto" else [])]
    args = ["farm", verb, name, "--store", "{{Param.Store}}", *map(_literal, options), *more]
    return {"actions": {"onRun": {"command": "{{Param.Pronk}}", "args": args}}}


def _literal(text: str) -> str:
    """Return text that is no format string: braces of it would be looked up."""
    return re.sub(r"\{(?=\{)", "{ ", text)


def _step_name(verb: str, name: str, number: int) -> str:
    plain = re.sub(r"[^ -~]", "_", name)
    text = f"{verb} {plain}"
    return text if len(text) <= MAX_STEP_NAME - 6 else f"{text[: MAX_STEP_NAME - 6]} {number}"


def job_scene(order: Order, file: Path, template: Path, options: Sequence[str]) -> JobScene:
    """Return a scene as a template names it: shipped ones by name, others by their files.

    Args:
        order: of its film.
        file: of the scene.
        template: file of the template, beside which the paths of scenes begin.
        options: of the command line that change the scene.
    """
    is_shipped = file.resolve().is_relative_to(library().resolve())
    relative = os.path.relpath(file.resolve(), template.resolve().parent)
    return JobScene(order, None if is_shipped else Path(relative).as_posix(), tuple(options))


def write_template(scenes: Sequence[JobScene], place: Path) -> None:
    """Write the template of a job.

    Raises:
        StoreError: it cannot be written.
    """
    try:
        make_folder(place.resolve().parent)
        write_if_changed(place, job_template(scenes).encode())
    except OSError as error:
        raise StoreError(f"{place}: {error.strerror or error}") from error
