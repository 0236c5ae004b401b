"""Addresses of stores: a folder, or an URL of fsspec."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from pipeline.errors import StoreError, UsageError

SSH = ("sftp", "ssh")
"""Protocols that have one connection, which may break."""

KNOWN_HOSTS = "~/.ssh/known_hosts"
"""Keys of hosts that the user has accepted."""

_PACKAGES = {"s3": "s3fs", "s3a": "s3fs", "sftp": "paramiko", "ssh": "paramiko", "gs": "gcsfs"}
"""Packages that protocols need besides fsspec."""


def opened_address(address: str) -> tuple[Any, str]:
    """Return the file system of fsspec that an address names, and the place in it.

    Every call makes a connection of its own, where the protocol has connections.

    Raises:
        UsageError: the address holds a password, or a package for it is missing.
        StoreError: the store cannot be reached.
    """
    refuse_passwords(address)
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise UsageError("stores need the package fsspec: pip install fsspec") from None
    try:
        if urlsplit(address).scheme in SSH:
            files, place = url_to_fs(
                address, skip_instance_cache=True, host_key_policy=_known_hosts()
            )
        else:
            files, place = url_to_fs(address, use_listings_cache=False)
    except ImportError:
        name = _PACKAGES.get(urlsplit(address).scheme, "the one that fsspec's manual names")
        raise UsageError(f"--store {address}: needs a package: pip install {name}") from None
    except ValueError as error:
        raise UsageError(f"--store {address}: {error}") from None
    except Exception as error:
        raise StoreError(f"--store {address}: cannot be reached ({reason_of(error)})") from error
    return files, place


def _known_hosts() -> Any:
    """Return the policy of paramiko that lets in known hosts alone; fsspec lets in every host."""
    import paramiko

    class KnownHosts(paramiko.MissingHostKeyPolicy):  # type: ignore[misc] # has no types
        """Compares a host's key with those that this user has accepted by ssh."""

        def missing_host_key(self, client: Any, hostname: str, key: Any) -> None:
            """Refuse a key that the user does not know; fsspec loads none by itself."""
            file = Path(KNOWN_HOSTS).expanduser()
            known = paramiko.HostKeys(str(file) if file.is_file() else None)
            if not known.check(hostname, key):
                raise paramiko.SSHException(
                    f"{KNOWN_HOSTS} does not have the key of {hostname}; log in by ssh once"
                )

    return KnownHosts


def refuse_passwords(address: str) -> None:
    """Refuse an address that holds a password, which would stand in logs and lists of processes.

    Raises:
        UsageError: it does; the message leaves it out.
    """
    # A chain of fsspec, such as simplecache::sftp://host, has several.
    for part in address.split("::"):
        try:
            found = urlsplit(part)
            has_password = found.password is not None
        except ValueError as error:
            raise UsageError(f"--store: no address that can be read ({error})") from None
        if has_password:
            raise UsageError(
                f"--store {found.scheme}://...@{found.hostname}: the address holds a password; "
                "give it by the environment, for example "
                f"FSSPEC_{found.scheme.upper()}_PASSWORD, and leave it out here"
            )


def reason_of(error: BaseException) -> str:
    """Return the error of a library in one line."""
    text = str(error).strip().splitlines()
    return f"{type(error).__name__}: {text[0]}" if text else type(error).__name__
