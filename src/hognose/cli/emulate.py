"""`hognose emulate`."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hognose.cli.options import Flag, PlanOrTask


def emulate(plan: PlanOrTask, /, *, network: Path | None = None, port: int = 0, without_twin: Flag = False) -> int:
    """Emulate the drives of an arm, standing where a plan begins, until Ctrl-C.

    `hognose run --network` connects to them. They outlive whatever commands them, as real ones do.

    Parameters
    ----------
    network
        The network file whose drives they are; one for each cable from node 1 on, and the slider's, unless given. A
        slider on a serial board gets a line of its own, on the file's port if that is a socket of this machine.
    port
        Of this machine alone (127.0.0.1); a free one unless given.
    without_twin
        Their motors move nothing, instead of the twin of the arm.
    """
    from hognose.cli.console import plan_of, say
    from hognose.drive.emulator.board_line import BoardServer, port_of
    from hognose.drive.emulator.process import serve
    from hognose.drive.network_spec import EMULATED
    from hognose.drive.tcp_hub import Hub
    from hognose.studies.rehearsal import Rehearsal

    hub, board = Hub(port), None
    try:
        made = plan_of(plan, False)
        with tempfile.TemporaryDirectory(prefix="hognose-emulate-") as folder:
            file = Path(folder) / "plan.parquet"
            made.save(file)
            emulator = Rehearsal(file, not without_twin, network)()
        slider = emulator.network.spec.slider
        if emulator.board is not None and slider is not None:
            board = BoardServer(emulator.board, port_of(slider.port))
        line = "" if board is None else f'\n[slider]\nkind = "serial"\nport = "{board.url}"'
        say(
            f"{len(emulator.drives)} drives{' and the board of the slider' if board else ''}, standing where "
            f"{made.task.name} begins. In the network file:\n"
            f'[bus]\ninterface = "{EMULATED}"\nchannel = "127.0.0.1:{hub.port}"{line}'
        )
        serve(emulator, hub, board)
    except KeyboardInterrupt:
        return 0
    finally:
        hub.close()
        if board is not None:
            board.close()
    return 0
