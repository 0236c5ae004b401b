"""Settings that all tests share."""

from __future__ import annotations

from hypothesis import settings

# Holds numpy to the common arithmetic, so it comes before everything that loads numpy.
import pipeline  # noqa: F401

# A busy machine is no fault of the code: no test is judged by the clock. The same examples are
# tried every time, so that a red run can be repeated; the nightly tier tries others.
settings.register_profile("steady", deadline=None, derandomize=True)
settings.register_profile("random", deadline=None)
settings.load_profile("steady")
