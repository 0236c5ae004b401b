"""The studio of the production's tests."""

from __future__ import annotations

from tests.production.conftest import unmade

__all__ = ["unmade"]
