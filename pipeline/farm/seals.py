"""Seals: digests of contents, and JSON objects that hold their own."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

SEAL = "seal"
"""Name of the digest in a JSON object."""


def digest_of(data: bytes) -> str:
    """Return the digest of an object's content."""
    return hashlib.blake2b(data, digest_size=20).hexdigest()


def sealed(members: Mapping[str, Any]) -> bytes:
    """Return members as JSON text with a digest of them."""
    return (_json({**members, SEAL: digest_of(_json(members).encode())}) + "\n").encode()


def unsealed(data: bytes) -> dict[str, Any] | None:
    """Return the members of `sealed`, None if they are not as they were written."""
    try:
        members: dict[str, Any] = json.loads(data)
        seal = members.pop(SEAL)
    except (ValueError, KeyError, AttributeError, TypeError):
        return None
    return members if seal == digest_of(_json(members).encode()) else None


def _json(members: Mapping[str, Any]) -> str:
    return json.dumps(members, sort_keys=True, ensure_ascii=True)
