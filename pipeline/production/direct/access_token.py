"""Access token: what a program that connects to a port has to say first.

Every program of this machine reaches a port, and so does every page of a browser, be it under
another name (DNS rebinding) or by a request of another protocol whose body repeats a message.
The file that holds the token is its owner's alone, and a browser decides on its first line itself.

Source: Jackson et al. 2007; Topf 2001.
"""

from __future__ import annotations

import contextlib
import hmac
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.atomic_file import make_folder, write_private
from pipeline.errors import StoreError, UsageError
from pipeline.production.direct.messages import decoded

HELLO = "hello"
"""Method of the first request at a port."""

TOKEN_BYTES = 32
"""Random bytes of a token."""

TOKEN_FILE = re.compile(rb"[A-Za-z0-9_-]{43}\n?")
"""Content of a token file: base64 of `TOKEN_BYTES`."""


def is_hello(line: bytes, token: str) -> bool:
    """Return whether a line is a request `hello` with this token."""
    try:
        request = decoded(line)
    except ValueError:
        return False
    if not isinstance(request, dict) or request.get("method") != HELLO:
        return False
    params = request.get("params")
    given = params.get("token") if isinstance(params, dict) else None
    if not isinstance(given, str):
        return False
    return hmac.compare_digest(given.encode("utf-8", "surrogatepass"), token.encode())


@contextmanager
def token_in(file: Path) -> Iterator[str]:
    """Make a token, hold it in a file for its owner alone, and remove the file at the end.

    Raises:
        UsageError: there is a file that holds something else.
        StoreError: the file cannot be written, or other users can read what is written there.
    """
    _refuse_other(file)
    token = secrets.token_urlsafe(TOKEN_BYTES)
    content = f"{token}\n".encode()
    try:
        make_folder(file.parent)
        write_private(file, content)
    except OSError as error:
        reason = error.strerror or str(error)
        raise StoreError(
            f"{file}: the token cannot be written ({reason}); choose another file with --token-file"
        ) from error
    try:
        yield token
    finally:
        with contextlib.suppress(OSError):
            # Another session may have written its own since.
            if file.read_bytes() == content:
                file.unlink()


def _refuse_other(file: Path) -> None:
    """Refuse to replace anything but the token of an earlier session.

    Raises:
        UsageError: there is something else.
    """
    try:
        with file.open("rb") as opened:
            start = opened.read(64)
    except FileNotFoundError:
        return
    except OSError:
        start = b""
    if TOKEN_FILE.fullmatch(start) is None:
        raise UsageError(f"{file}: there is something else already; choose another --token-file")
