"""The file of a record: every record is on its way to the disk when the call returns, and a full disk is no crash."""

from __future__ import annotations

import os
import shutil
import threading
from contextlib import suppress
from pathlib import Path

from hognose.errors import InputError

#: How often what was written is forced onto the disk (s). It takes some milliseconds, so a thread does it.
SYNC_EVERY = 0.5
#: So many bytes of the disk are left to others.
_LEFT_FREE = 64_000_000


def refuse_full_disk(file: Path, needed: int) -> None:
    """Raise an InputError if so many bytes do not fit on the disk of a file, with some left for others."""
    folder = file.absolute().parent
    try:
        free = shutil.disk_usage(folder).free
    except OSError as error:
        raise InputError(f"{file}: cannot write: {error.strerror}. Name a file in a folder that is there.") from None
    if free < needed + _LEFT_FREE:
        raise InputError(
            f"{file}: a record of this run may take {needed / 1e6:,.0f} MB, but the disk has {free / 1e6:,.0f} MB "
            f"free, of which {_LEFT_FREE / 1e6:.0f} MB are left to others; make room, or name a file on another disk"
        )


class RecordFile:
    """A new file that foxglove-sdk writes to.

    What a program has written is not lost when it is killed, since the kernel has it. What the kernel has is forced
    onto the disk twice a second, in case the power fails. After the first failure nothing more is written, and the file
    ends with the last record that is whole.

    Attributes
    ----------
    path
    fault
        Why nothing is written any more, in a sentence; None as long as all is well.

    Raises
    ------
    InputError
        The file is there already, or cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.fault: str | None = None
        try:
            self._number = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
        except FileExistsError:
            raise InputError(f"{path}: is there already; records are never written over. Name another file.") from None
        except (OSError, ValueError) as error:
            said = getattr(error, "strerror", None) or error
            raise InputError(f"{path}: cannot write: {said}. Name another file.") from None
        self._whole = self._synced = 0
        self._ends = threading.Event()
        self._syncs = threading.Thread(target=self._sync_often, name="record-sync", daemon=True)
        self._syncs.start()

    def write(self, data: bytes | bytearray) -> int:
        """Write all of it, or keep the fault and cut off what is not whole."""
        if self.fault is None:
            try:
                left = memoryview(data)
                while left:
                    left = left[os.write(self._number, left) :]
            except OSError as error:
                self._fail(error)
                with suppress(OSError):
                    os.ftruncate(self._number, self._whole)
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """The place in the file; it is written from front to back only."""
        return os.lseek(self._number, offset, whence)

    def flush(self) -> None:
        """What was written until now is whole."""
        if self.fault is None:
            self._whole = os.lseek(self._number, 0, os.SEEK_CUR)

    def close(self) -> None:
        """Force everything onto the disk and let go of the file."""
        self._ends.set()
        self._syncs.join()
        self._sync()
        os.close(self._number)

    def _sync_often(self) -> None:
        while not self._ends.wait(SYNC_EVERY):
            self._sync()

    def _sync(self) -> None:
        whole = self._whole
        if whole != self._synced and self.fault is None:
            try:
                os.fsync(self._number)
                self._synced = whole
            except OSError as error:
                self._fail(error)

    def _fail(self, error: OSError) -> None:
        self.fault = (
            f"{self.path}: the record cannot be written any more: {error.strerror}. It is whole up to here; what "
            "follows is not recorded."
        )
