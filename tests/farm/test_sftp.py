"""A store behind SFTP: an independent server, keys, known hosts, connections that break."""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from pipeline.errors import StoreError
from pipeline.farm import store_address
from pipeline.farm.store import ObjectMissing, Store
from tests.production.conftest import FRAMES, Studio
from tests.production.killed_runs import contents_of

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(
        (find_spec("paramiko") is None or find_spec("asyncssh") is None)
        and not os.environ.get("PRONK_FARM"),
        reason="needs paramiko and asyncssh, which `make test-all` installs",
    ),
    # Of the libraries, whose connections break.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

PASSWORD = "a-password-that-nobody-sees"

Pronk = Callable[..., tuple[int, str, str]]


@dataclass
class Server:
    """An SFTP server of this process.

    Attributes:
        folder: that it serves as its root.
        port: that it listens at.
        key: line of known_hosts for it.
        connections: that are open.
        acceptor: of connections.
        loop: that serves.
    """

    folder: Path
    port: int = 0
    key: str = ""
    connections: list[Any] = field(default_factory=list)
    acceptor: Any = None
    loop: asyncio.AbstractEventLoop = field(default_factory=asyncio.new_event_loop)

    @property
    def address(self) -> str:
        """Address of a store."""
        return f"sftp://somebody@127.0.0.1:{self.port}/films"

    async def listen(self) -> None:
        """Begin to serve."""
        import asyncssh

        server = self

        class Door(asyncssh.SSHServer):
            """Lets in whoever knows the password."""

            def connection_made(self, conn: Any) -> None:
                server.connections.append(conn)

            def password_auth_supported(self) -> bool:
                return True

            def validate_password(self, username: str, password: str) -> bool:
                return (username, password) == ("somebody", PASSWORD)

        key = asyncssh.generate_private_key("ssh-ed25519")
        self.acceptor = await asyncssh.create_server(
            Door,
            "127.0.0.1",
            0,
            server_host_keys=[key],
            sftp_factory=lambda chan: asyncssh.SFTPServer(chan, chroot=str(self.folder)),
        )
        self.port = self.acceptor.get_port()
        public = key.export_public_key().decode().strip()
        self.key = f"[127.0.0.1]:{self.port} {public}\n"

    async def close(self) -> None:
        """End all connections."""
        for connection in self.connections:
            connection.abort()
        self.acceptor.close()
        await self.acceptor.wait_closed()

    def break_connections(self) -> None:
        """Break all connections, as a network does."""
        for connection in self.connections:
            self.loop.call_soon_threadsafe(connection.abort)
        self.connections.clear()


@pytest.fixture(scope="module")
def serving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Return a server that serves."""
    server = Server(tmp_path_factory.mktemp("served"))
    thread = threading.Thread(target=server.loop.run_forever, daemon=True)
    thread.start()
    asyncio.run_coroutine_threadsafe(server.listen(), server.loop).result(30)
    yield server
    asyncio.run_coroutine_threadsafe(server.close(), server.loop).result(30)
    server.loop.call_soon_threadsafe(server.loop.stop)
    thread.join(10)
    server.loop.close()


@pytest.fixture
def server(serving: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Server:
    """Return the server with empty films; the user knows its key and its password."""
    from fsspec.config import conf, set_conf_env

    known = tmp_path / "known_hosts"
    known.write_text(serving.key)
    monkeypatch.setattr(store_address, "KNOWN_HOSTS", str(known))
    monkeypatch.setenv("FSSPEC_SFTP_PASSWORD", PASSWORD)
    # Keys of whoever runs the tests are none of this server's business.
    monkeypatch.setenv("FSSPEC_SFTP", '{"look_for_keys": false, "allow_agent": false}')
    # Read once, when fsspec is imported.
    monkeypatch.setitem(conf, "sftp", {})
    set_conf_env(conf)
    for path in serving.folder.iterdir():
        path.rename(tmp_path / path.name)
    return serving


def test_objects_are_written_whole_and_read_in_part(server: Server, tmp_path: Path) -> None:
    store = Store(server.address)
    assert store.address == server.address
    store.put("a/b", b"0123456789")
    store.put("a/b", b"9876543210")
    assert store.get("a/b", 3, 6) == b"654"
    assert store.create("a/class.json", b"first")
    assert not store.create("a/class.json", b"second")
    file = tmp_path / "file"
    file.write_bytes(b"x" * 100_000)
    store.put("a/file", file)
    sizes = {name: entry.size for name, entry in store.names("a").items()}
    assert sizes == {"b": 10, "class.json": 5, "file": 100_000}
    assert all(entry.time > 0.0 for entry in store.names("a").values())
    assert "a" in store.folders("")
    store.remove("a/b")
    with pytest.raises(ObjectMissing):
        store.get("a/b")
    assert list((server.folder / "films/.unfinished").iterdir()) == []


def test_a_broken_connection_is_made_again(server: Server, pauses: list[float]) -> None:
    store = Store(server.address)
    store.put("a", b"1")
    server.break_connections()
    assert store.get("a") == b"1"
    server.break_connections()
    store.put("a", b"2")
    assert store.get("a") == b"2"
    assert pauses


def test_an_unknown_host_is_refused(server: Server, tmp_path: Path) -> None:
    (tmp_path / "known_hosts").write_text("")
    with pytest.raises(StoreError, match=r"does not have the key of \[127\.0\.0\.1\]"):
        Store(server.address)


def test_a_wrong_password_is_told_without_it(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    from fsspec.config import conf

    monkeypatch.setitem(conf, "sftp", {**conf["sftp"], "password": "another-secret"})
    with pytest.raises(StoreError, match="cannot be reached") as told:
        Store(server.address)
    assert "another-secret" not in str(told.value)


def test_a_film_through_sftp_is_the_rendered_one(
    server: Server, film: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    arguments = (film.scene, "--store", server.address)
    told = [
        pronk("farm", "simulate", *arguments),
        *(pronk("farm", "frames", *arguments, "--shard", f"{n}/2", "--json") for n in (1, 2)),
        pronk("farm", "status", "--store", server.address),
        pronk("farm", "assemble", *arguments, "--out", tmp_path / "out"),
    ]
    assert [code for code, _, _ in told] == [0] * 5, told
    assert f"{FRAMES} of {FRAMES}" in told[3][1]
    assert contents_of(tmp_path / "out/tiny") == film.contents()
    assert not any(PASSWORD in text for _, out, err in told for text in (out, err))
    files = [path for path in server.folder.rglob("*") if path.is_file()]
    assert files
    assert not any(PASSWORD.encode() in path.read_bytes() for path in files)
