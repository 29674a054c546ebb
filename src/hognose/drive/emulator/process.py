"""Emulated drives as a process of their own: drives answer while the program that commands them is busy, or dead."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection

from hognose.drive.emulator.board_line import BoardServer
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.faults import Fault
from hognose.drive.tcp_hub import Hub
from hognose.errors import InputError

#: How long (s) frames are waited for before the motors move on.
_PAUSE = 5e-4
#: The process says its port within this (s).
_PATIENCE = 60.0
#: Makes the emulator, in the process.
Make = Callable[[], Emulator]


class EmulatorProcess:
    """Emulated drives on a TCP bus of this machine.

    Attributes
    ----------
    channels
        Of the bus, or of both, as a network file has them: interface `hognose`, this channel.
    slider_port
        Of the slider's board, as a network file has it; empty if the slider is on the bus.
    """

    def __init__(self, make: Make) -> None:
        """Start it; `make` is called in the process, and must be a function of a module.

        Raises
        ------
        InputError
            It does not start.
        """
        # A process that is forked from a program with threads may hang.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(make, theirs), daemon=True)
        self._process.start()
        theirs.close()
        try:
            said = self._pipe.recv() if self._pipe.poll(_PATIENCE) else None
        except EOFError:  # it ended before it could say anything
            said = None
        if not isinstance(said, tuple):
            self.close()
            raise InputError(f"the emulated drives did not start{'' if said is None else f': {said}'}")
        ports, self.slider_port = said
        self.channels: tuple[str, ...] = tuple(f"127.0.0.1:{port}" for port in ports)

    @property
    def channel(self) -> str:
        """Of the first bus."""
        return self.channels[0]

    def inject(self, fault: Fault) -> None:
        """Let something go wrong."""
        self._pipe.send(fault)

    def ask(self) -> None:
        """Ask what is to be seen of the arm; `sight` has it when it came, and nothing if the process has ended."""
        with suppress(OSError):
            self._pipe.send(None)

    def sight(self, patience: float = 0.0) -> object:
        """What was asked for, of `Plant.sight`; None if it did not come within some patience (s).

        None, too, if the process has ended: that its drives are silent is what has to be said then.
        """
        try:
            return self._pipe.recv() if self._pipe.poll(patience) else None
        except (EOFError, OSError):
            return None

    def close(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.join(_PATIENCE)
        self._pipe.close()


def serve(
    emulator: Emulator,
    hubs: Sequence[Hub],
    board: BoardServer | None = None,
    goes_on: Callable[[], bool] = lambda: True,
) -> None:
    """Let emulated drives answer on the hubs of their buses, and a slider's board on its line, in real time."""
    gc.disable()
    began = time.monotonic()
    while goes_on():
        for k, hub in enumerate(hubs):
            frames = hub.take(_PAUSE / len(hubs))
            emulator.receive(frames, time.monotonic() - began, k)
        now = time.monotonic() - began
        for k, hub in enumerate(hubs):
            hub.give(emulator.send(now, k))
        if board is not None:
            board.serve(now)


def _serve(make: Make, pipe: Connection) -> None:
    """Serve emulated drives until the pipe is closed; Ctrl-C is for the program that commands them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        emulator = make()
        hubs = [Hub(bitrate=bus.bitrate) for bus in emulator.network.spec.buses]
        board = None if emulator.board is None else BoardServer(emulator.board)
    except Exception as error:  # told to who started it
        pipe.send(str(error))
        return
    pipe.send(([hub.port for hub in hubs], "" if board is None else board.url))

    def goes_on() -> bool:
        try:
            if pipe.poll():
                asked = pipe.recv()
                if asked is None:
                    pipe.send(emulator.sight())
                else:
                    emulator.inject(asked)
        except (EOFError, OSError):
            return False
        return True

    serve(emulator, hubs, board, goes_on)
