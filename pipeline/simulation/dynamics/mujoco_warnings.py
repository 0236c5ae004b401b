"""MuJoCo warnings: told as other warnings are.

Left alone, MuJoCo writes them into a file in the folder that it is called from.
"""

from __future__ import annotations

import logging
from typing import Any


def tell_warnings(mujoco: Any) -> None:
    """Let MuJoCo's warnings be told, unless somebody has said how."""
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_tell)


def _tell(message: str) -> None:
    logging.getLogger(__name__).warning("MuJoCo: %s", message)
