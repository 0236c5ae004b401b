"""Status watch: the status of a store, once or again and again, as a table and a page."""

from __future__ import annotations

import time
from pathlib import Path

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import StoreError
from pipeline.farm.status import FilmStatus, status_table, statuses
from pipeline.farm.status_page import StatusPage
from pipeline.farm.store import Store
from pipeline.production.run.progress import Reporter


def report_status(
    store: Store, reporter: Reporter, page: Path | None = None, interval: float | None = None
) -> None:
    """Report how far the films of a store are.

    Args:
        store: of the farm.
        reporter: of the result.
        page: file of the page, None for none.
        interval: after which it is done again until all frames are there [s]; None for once.

    Raises:
        StoreError: the store cannot be read, or the page not be written.
    """
    writer = StatusPage(store)
    while True:
        found = statuses(store, time.time())
        reporter.result(
            status_table(found) if found else f"{store.address}: has no films",
            store=store.address,
            films=[status.facts for status in found],
        )
        if page is not None:
            _write(page, writer.text(found, time.strftime("%Y-%m-%d %H:%M:%S")))
        if interval is None or _is_over(found):
            return
        time.sleep(interval)


def _is_over(found: list[FilmStatus]) -> bool:
    return all(len(status.done) == status.film.frames for status in found) and bool(found)


def _write(page: Path, text: str) -> None:
    try:
        make_folder(page.resolve().parent)
        write_if_changed(page, text.encode())
    except OSError as error:
        raise StoreError(f"{page}: {error.strerror or error}") from error
