"""Farm run: the films of a command on the engine that it names."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pipeline.errors import UsageError
from pipeline.farm.driver import Driver, ReportError
from pipeline.farm.engine import Engine
from pipeline.farm.process_engine import ProcessEngine
from pipeline.farm.store import Store
from pipeline.farm.tasks import WorkerSettings
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from render.backend import Choice

CORES = 4
"""Cores of a worker: more of them for one worker gain less than another worker does."""


@dataclass(frozen=True, slots=True)
class FarmSettings:
    """How films are made.

    Attributes:
        store: its address.
        on: "local", "auto" or the address of a Ray cluster.
        jobs: workers on this machine, None for as many as its cores suffice for.
        cores: of each worker, None for `CORES`.
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
    engine = _engine(settings, store)
    worker = WorkerSettings(store.address, mixed=settings.mixed)
    assembler = ProcessEngine(1, worker, "assembler")
    driver = Driver(
        scenes, order_of, store, engine, assembler, reporter, report_error, settings.strict
    )
    return driver.run()


def _engine(settings: FarmSettings, store: Store) -> Engine:
    if settings.on != "local":
        from pipeline.farm.ray_engine import RayEngine

        worker = WorkerSettings(store.address, settings.backend, mixed=settings.mixed)
        return RayEngine(settings.on, worker, settings.jobs, settings.cores)
    cores = os.cpu_count() or 1
    jobs = settings.jobs or max(cores // (settings.cores or CORES), 1)
    threads = settings.cores or max(cores // jobs, 1)
    return ProcessEngine(
        jobs, WorkerSettings(store.address, settings.backend, threads, settings.mixed)
    )
