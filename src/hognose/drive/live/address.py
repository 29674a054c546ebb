"""Where a run is followed: a small file beside its record, which only its owner may read, as long as it goes on."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from hognose.errors import InputError

#: Behind the name of the record.
SUFFIX = ".live.json"
#: The file is small; what is longer is none.
_LONGEST = 10_000
_LAST_PORT = 65535


@dataclass(frozen=True)
class Address:
    """Where a run is followed.

    Attributes
    ----------
    port
        On 127.0.0.1.
    token
        The secret that opens it; not shown by `repr`.
    pid
        Of the program that runs the plan.
    record
        The record that it writes.
    """

    port: int
    token: str = field(repr=False)
    pid: int
    record: Path

    @property
    def file(self) -> Path:
        """The file that says so."""
        return file_of(self.record)

    def write(self) -> None:
        """Write the file, whole and readable by its owner only, over one that was left by a run that is gone.

        Raises
        ------
        InputError
            It cannot be written.
        """
        said = {
            "host": "127.0.0.1",
            "port": self.port,
            "token": self.token,
            "pid": self.pid,
            "record": str(self.record.absolute()),
        }
        beside = self.file.with_name(f".{self.file.name}.{self.pid}")
        try:
            with suppress(FileNotFoundError):
                os.unlink(beside)
            number = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(number, "w", encoding="utf-8") as stream:
                json.dump(said, stream)
            os.replace(beside, self.file)
        except OSError as error:
            with suppress(OSError):
                os.unlink(beside)
            raise InputError(
                f"{self.file}: cannot write where the run is followed: {error.strerror}. Name a record in a folder "
                "that can be written to"
            ) from None

    def remove(self) -> None:
        """Remove the file, unless another run has its own there by now."""
        with suppress(OSError, InputError):
            if _read(self.file) == self:
                self.file.unlink()

    @property
    def is_gone(self) -> bool:
        """Whether no program of that number goes on; False also where that cannot be found out."""
        if os.name != "posix":  # elsewhere the question would end the program
            return False
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return True
        except OSError:
            return False
        return False


def file_of(record: Path) -> Path:
    """The file beside a record."""
    return record.with_name(record.name + SUFFIX)


def address_of(record: Path | str) -> Address:
    """Where the run of a record is followed; the file that says so will do, too.

    Raises
    ------
    InputError
        There is no such file, so nobody runs it any more; or it is none.
    """
    path = Path(record)
    file = path if path.name.endswith(SUFFIX) else file_of(path)
    if not file.exists() and path.is_file():
        raise InputError(f"{path}: its run is over, there is no {file.name} beside it; `hognose log {path}` reads it")
    return _read(file)


def newest_addresses(folder: Path | str = ".") -> list[Address]:
    """Where the runs of a folder's records are followed, the one that began last first.

    Raises
    ------
    InputError
        There is none.
    """
    found: list[tuple[int, Address]] = []
    for file in Path(folder).glob(f"*.mcap{SUFFIX}"):
        with suppress(OSError, InputError):
            found.append((file.stat().st_mtime_ns, _read(file)))
    if not found:
        raise InputError(
            "nothing runs in this folder: there is no *.mcap.live.json. Name the record of a run that goes on elsewhere"
        )
    return [each for _, each in sorted(found, key=lambda pair: pair[0], reverse=True)]


def _read(file: Path) -> Address:
    try:
        with file.open("rb") as stream:
            said = json.loads(stream.read(_LONGEST))
        port, token, pid = said["port"], said["token"], said["pid"]
        sound = type(port) is int and 0 < port <= _LAST_PORT and type(pid) is int and pid > 0 and type(token) is str
        if not sound:
            raise ValueError("port")
    except OSError as error:
        raise InputError(f"{file}: no run can be followed there: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{file}: does not say where a run is followed; expected what `hognose run` writes") from None
    # The folder may have another name by now, or be seen from another machine: what is beside the file counts.
    return Address(port, token, pid, file.with_name(file.name.removesuffix(SUFFIX)))
