"""Farm run: the films of a command on the engine that it names."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from pipeline.errors import PronkError, UsageError
from pipeline.farm.driver import Driver, ReportError
from pipeline.farm.engine import Engine
from pipeline.farm.process_engine import ProcessEngine
from pipeline.farm.store import Store
from pipeline.farm.tasks import WorkerSettings
from pipeline.farm.worker_needs import WorkerNeeds
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from render.backend import Choice

LOOKED_AT = 16
"""Scenes by which the needs of workers are estimated."""

CORES_OF_ASSEMBLER = 4
"""Films are assembled at once, one for so many cores of this machine."""


@dataclass(frozen=True, slots=True)
class FarmSettings:
    """How films are made.

    Attributes:
        store: its address.
        on: "local", "auto" or the address of a Ray cluster.
        jobs: workers on this machine, None for as many as its cores suffice for.
        cores: of each worker, None for what scenes need by their estimate.
        backend: of the renderer.
        strict: whether notes are an error.
        mixed: whether classes of renderers may be mixed.
    """

    store: str
    on: str = "local"
    jobs: int | None = None
    cores: int | None = None
    backend: Choice = "auto"
    strict: bool = False
    mixed: bool = False


def render_films(
    scenes: Sequence[str],
    order_of: Callable[[str], Order],
    settings: FarmSettings,
    reporter: Reporter,
    report_error: ReportError,
) -> int:
    """Make the films of scenes and return the worst exit code, which is the highest.

    Raises:
        UsageError: a setting is wrong, or a package is missing.
        StoreError: the store cannot be reached.
    """
    store = Store(settings.store)
    if store.is_memory:
        raise UsageError(
            f"--store {settings.store}: memory is of one process; name a folder that workers reach"
        )
    engine = _engine(settings, store, needs_of(scenes, order_of))
    worker = WorkerSettings(store.address, mixed=settings.mixed)
    assemblers = max((os.cpu_count() or 1) // CORES_OF_ASSEMBLER, 1)
    assembler = ProcessEngine(min(assemblers, len(scenes)), worker, "assembler")
    driver = Driver(
        scenes, order_of, store, engine, assembler, reporter, report_error, settings.strict
    )
    return driver.run()


def needs_of(scenes: Sequence[str], order_of: Callable[[str], Order]) -> WorkerNeeds:
    """Return what workers need for some of the scenes; those that are wrong are told later."""
    needs = WorkerNeeds(1, 0)
    for name in scenes[:: max(len(scenes) // LOOKED_AT, 1)]:
        with suppress(PronkError):
            needs = needs.with_those(WorkerNeeds.of(order_of(name).scene))
    return needs


def _engine(settings: FarmSettings, store: Store, needs: WorkerNeeds) -> Engine:
    cores = settings.cores or needs.cores
    if settings.on != "local":
        from pipeline.farm.ray_engine import RayEngine

        worker = WorkerSettings(store.address, settings.backend, mixed=settings.mixed)
        return RayEngine(settings.on, worker, settings.jobs, cores, needs.memory)
    there = os.cpu_count() or 1
    jobs = settings.jobs or max(there // cores, 1)
    threads = settings.cores or max(there // jobs, 1)
    return ProcessEngine(
        jobs, WorkerSettings(store.address, settings.backend, threads, settings.mixed)
    )
