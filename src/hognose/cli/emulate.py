"""`hognose emulate`."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hognose.cli.options import Flag, PlanOrTask, Several

if TYPE_CHECKING:
    from hognose.drive.emulator.emulator import Emulator
    from hognose.drive.tcp_hub import Hub
    from hognose.planning import Plan


def emulate(
    plan: PlanOrTask,
    /,
    *,
    network: Path | None = None,
    port: int = 0,
    without_twin: Flag = False,
    not_homed: Flag = False,
    fault: Several = (),
) -> int:
    """Emulate the drives of an arm, standing where a plan begins, until Ctrl-C.

    `hognose run --network` connects to them. They outlive whatever commands them, as real ones do.

    Parameters
    ----------
    network
        The network file whose drives they are; one for each cable from node 1 on, and the slider's, unless given. A
        slider on a serial board gets a line of its own, on the file's port if that is a socket of this machine.
    port
        Of this machine alone (127.0.0.1); a free one unless given. A second bus has the next one.
    without_twin
        Their motors move nothing, instead of the twin of the arm.
    fault
        Make a drive fail, as NODE:KIND:SECONDS from now on, such as 9:overcurrent:20; may be given several times.
    not_homed
        Their supply has just come on: they do not know where they are, until `hognose home` tells them.
    """
    from hognose.cli.console import plan_of, say
    from hognose.drive.emulator.board_line import BoardServer, port_of
    from hognose.drive.emulator.faults import Fault
    from hognose.drive.emulator.process import serve
    from hognose.drive.tcp_hub import Hub

    hubs, board = [Hub(port)], None
    try:
        made = plan_of(plan, False)
        emulator = _standing(made, network, not without_twin, not not_homed)
        for text in fault:
            emulator.inject(Fault.parsed(text, emulator.network.nodes, emulator.network.board_node))
        buses, slider = emulator.network.spec.buses, emulator.network.spec.slider
        hubs[0].bitrate = buses[0].bitrate
        hubs += [Hub(port and port + 1, bus.bitrate) for bus in buses[1:]]
        told = _tables(hubs)
        if emulator.board is not None and slider is not None:
            board = BoardServer(emulator.board, port_of(slider.port))
            told.append(f'[slider]\nkind = "serial"\nport = "{board.url}"')
        what = f"{len(emulator.drives)} drives{' and the board of the slider' if board else ''}"
        hint = " Run it with --without-twin." if without_twin else ""
        say("\n".join([f"{what}, standing where {made.task.name} begins.{hint} In the network file:", *told]))
        serve(emulator, hubs, board)
    except KeyboardInterrupt:
        pass
    finally:
        for hub in hubs:
            hub.close()
        if board:
            board.close()
    return 0


def _standing(plan: Plan, network: Path | None, twin: bool, is_homed: bool) -> Emulator:
    """Emulated drives that stand where a plan begins."""
    from hognose.studies.rehearsal import Rehearsal

    with tempfile.TemporaryDirectory(prefix="hognose-emulate-") as folder:
        file = Path(folder) / "plan.parquet"
        plan.save(file)
        return Rehearsal(file, twin, network, is_homed)()


def _tables(hubs: Sequence[Hub]) -> list[str]:
    """The tables of a network file that lead to hubs."""
    from hognose.drive.network_spec import EMULATED

    return [
        f'[{table}]\ninterface = "{EMULATED}"\nchannel = "127.0.0.1:{hub.port}"\nbitrate = {hub.bitrate}'
        for table, hub in zip(("bus", "bus2"), hubs, strict=False)
    ]
