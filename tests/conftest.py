"""Settings that all tests share."""

from __future__ import annotations

import signal

import pytest
from hypothesis import settings

# Holds numpy to the common arithmetic, so it comes before everything that loads numpy.
import pipeline  # noqa: F401

# A busy machine is no fault of the code: no test is judged by the clock. The same examples are
# tried every time, so that a red run can be repeated; the nightly tier tries others.
settings.register_profile("steady", deadline=None, derandomize=True)
settings.register_profile("random", deadline=None)
settings.load_profile("steady")

# Tests in the background inherit that Ctrl-C is ignored, and so would the commands they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave most cases of a test marked `sample(n)` to the nightly tier, all but n of them.

    The kept ones lie evenly among its cases, the first of them always.
    """
    sampled: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker("sample") and not item.get_closest_marker("nightly"):
            sampled.setdefault(item.nodeid.split("[")[0], []).append(item)
    for cases in sampled.values():
        (count,) = cases[0].get_closest_marker("sample").args
        kept = {k * len(cases) // count for k in range(count)}
        for k, case in enumerate(cases):
            if k not in kept:
                case.add_marker(pytest.mark.nightly)
