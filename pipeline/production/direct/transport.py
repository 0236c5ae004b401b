"""Doors: where the other program comes in: standard input and output, or a socket.

A socket is open to this machine alone unless its author names another host. It is shut once
somebody has come in: a scene has one director.
"""

from __future__ import annotations

import contextlib
import io
import ipaddress
import os
import re
import socket
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import BinaryIO

from pipeline.errors import StoreError, UsageError
from pipeline.production.direct.framing import Wire

Say = Callable[[str], None]
Door = Callable[[Say], AbstractContextManager[Wire]]
"""Opens a wire, and says how to come in."""

LOOPBACK = "127.0.0.1"

BROWSER = re.compile(rb"[A-Z]+ \S+ HTTP/")
"""Begins what a browser sends: any page that it shows may have made it do so."""


def door_of(path: Path | None, number: int | None, host: str) -> Door:
    """Return the door that is asked for: standard input and output if none is.

    Raises:
        UsageError: there is none such.
    """
    if path is not None and number is not None:
        raise UsageError("--socket and --port are two doors; give one of them")
    if number is None and host != LOOPBACK:
        raise UsageError("--host is where a port is open to; give --port as well")
    if path is not None:
        return local(path)
    return standard if number is None else port(number, host)


@contextmanager
def standard(say: Say) -> Iterator[Wire]:
    """Open standard input and output; whatever else would be printed goes to standard error."""
    del say
    sys.stdout.flush()
    out = os.dup(1)
    os.dup2(2, 1)
    try:
        with (
            _closed(open(0, "rb", closefd=False)) as reader,
            _closed(open(out, "wb", closefd=False)) as writer,
        ):
            yield Wire(reader, writer)
    finally:
        sys.stdout.flush()
        os.dup2(out, 1)
        os.close(out)


def local(path: Path) -> Door:
    """Return the door that is a local socket at `path`, for its owner alone.

    Raises:
        UsageError: there is something else at `path`.
    """
    _refuse_taken(path)

    @contextmanager
    def door(say: Say) -> Iterator[Wire]:
        with _listening(socket.socket(socket.AF_UNIX)) as listener:
            before = os.umask(0o177)
            try:
                listener.bind(str(path))
            except OSError as error:
                reason = error.strerror or str(error)
                raise StoreError(f"{path}: no socket can be made there ({reason})") from error
            finally:
                os.umask(before)
            try:
                listener.listen(1)
                say(f"waiting at {path}")
                with _entered(listener) as wire:
                    yield wire
            finally:
                path.unlink(missing_ok=True)

    return door


def port(number: int, host: str) -> Door:
    """Return the door that is a port of TCP; 0 takes one that is free, and says which."""

    @contextmanager
    def door(say: Say) -> Iterator[Wire]:
        family, address = _address(host, number)
        with _listening(socket.socket(family)) as listener:
            try:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listener.bind(address)
            except OSError as error:
                reason = error.strerror or str(error)
                raise StoreError(f"{host}:{number}: cannot be listened at ({reason})") from error
            listener.listen(1)
            place = "{}:{}".format(*listener.getsockname()[:2])
            if not ipaddress.ip_address(listener.getsockname()[0]).is_loopback:
                say(f"note: whoever can reach {place} can direct this scene")
            say(f"waiting at {place}")
            with _entered(listener) as wire:
                yield wire

    return door


def _address(host: str, number: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    try:
        found = socket.getaddrinfo(host, number, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise UsageError(f"--host {host!r} is no address of this machine") from error
    return found[0], (str(found[4][0]), number)


def _listening(listener: socket.socket) -> AbstractContextManager[socket.socket]:
    return contextlib.closing(listener)


@contextmanager
def _entered(listener: socket.socket) -> Iterator[Wire]:
    """Wait for somebody who comes in, and shut the door; browsers are turned away."""
    while True:
        connection, _ = listener.accept()
        reader = connection.makefile("rb")
        first = _peeked(reader)
        if BROWSER.match(first) is None:
            break
        reader.close()
        connection.close()
    listener.close()
    with connection, _closed(reader), _closed(connection.makefile("wb")) as writer:
        yield Wire(reader, writer)


@contextmanager
def _closed(stream: BinaryIO) -> Iterator[BinaryIO]:
    """Close a stream in the end; what is not sent yet is for somebody who has gone."""
    try:
        yield stream
    finally:
        with contextlib.suppress(OSError):
            stream.close()


def _peeked(reader: io.BufferedReader) -> bytes:
    """Return the beginning of what comes first, which stays there to be read."""
    try:
        return reader.peek(64)[:64]
    except OSError:
        return b""


def _refuse_taken(path: Path) -> None:
    """Clear away the socket of a run that was killed; refuse anything else that is there."""
    if not hasattr(socket, "AF_UNIX"):
        raise UsageError("there are no local sockets on this system; give --port")
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{path}: no socket can be made there ({error.strerror})") from error
    if not stat.S_ISSOCK(mode):
        raise UsageError(f"{path}: there is something else already; choose another place")
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink(missing_ok=True)
            return
    raise UsageError(f"{path}: another run waits there already; choose another place")
