"""Stores in memory and in folders, one of them with a finished film."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from pathlib import Path

import pytest

from pipeline.farm import store as store_module
from pipeline.farm.film import Film
from pipeline.farm.shards import prepare_film, render_shard
from pipeline.farm.store import Store
from pipeline.production.run.progress import Reporter
from tests.production.conftest import (  # noqa: F401 # fixtures
    Studio,
    film,
    pronk,
    start,
    unmade,
)


@pytest.fixture
def memory() -> Store:
    """Return an empty store in memory."""
    return Store(f"memory://{uuid.uuid4().hex}")


@pytest.fixture(params=["memory", "renaming", "folder"])
def store(request: pytest.FixtureRequest, memory: Store, tmp_path: Path) -> Store:
    """Return an empty store of each way of writing: one request, renaming, links of a system."""
    if request.param == "folder":
        return Store(str(tmp_path / "store"))
    # As servers do whose files appear before they are complete.
    memory._renames = request.param == "renaming"
    return memory


@pytest.fixture
def pauses(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return the pauses of stores, which take no time."""
    taken: list[float] = []
    monkeypatch.setattr(store_module.time, "sleep", taken.append)
    return taken


@dataclass(frozen=True)
class Farmed:
    """A film whose frames are all in a store.

    Attributes:
        store: that has them.
        film: the film.
    """

    store: Store
    film: Film


@pytest.fixture(scope="session")
def farmed(unmade: Studio, tmp_path_factory: pytest.TempPathFactory) -> Farmed:  # noqa: F811
    """Return the tiny film in a store, its frames from two shards; shared, not to be changed."""
    store = Store(str(tmp_path_factory.mktemp("farmed")))
    made = prepare_film(unmade.order(), store, Reporter())
    for number in (2, 1):
        render_shard(unmade.order(), store, Reporter(), shard=f"{number}/2")
    return Farmed(store, made)
