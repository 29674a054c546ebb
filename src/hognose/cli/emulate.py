"""`hognose emulate`."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hognose.cli.options import Flag, PlanOrTask


def emulate(
    plan: PlanOrTask,
    /,
    *,
    network: Path | None = None,
    port: int = 0,
    without_twin: Flag = False,
    not_homed: Flag = False,
) -> int:
    """Emulate the drives of an arm, standing where a plan begins, until Ctrl-C.

    `hognose run --network` connects to them. They outlive whatever commands them, as real ones do.

    Parameters
    ----------
    network
        The network file whose drives they are; one for each cable from node 1 on, and the slider's, unless given.
    port
        Of this machine alone (127.0.0.1); a free one unless given. A second bus has the next one.
    without_twin
        Their motors move nothing, instead of the twin of the arm.
    not_homed
        Their supply has just come on: they do not know where they are, until `hognose home` tells them.
    """
    from hognose.cli.console import plan_of, say
    from hognose.drive.emulator.process import serve
    from hognose.drive.network_spec import EMULATED
    from hognose.drive.tcp_hub import Hub
    from hognose.studies.rehearsal import Rehearsal

    hubs = [Hub(port)]
    try:
        made = plan_of(plan, False)
        with tempfile.TemporaryDirectory(prefix="hognose-emulate-") as folder:
            file = Path(folder) / "plan.parquet"
            made.save(file)
            emulator = Rehearsal(file, not without_twin, network, not not_homed)()
        buses = emulator.network.spec.buses
        hubs[0].bitrate = buses[0].bitrate
        hubs += [Hub(port and port + k, bus.bitrate) for k, bus in enumerate(buses) if k]
        told = "\n".join(
            f'[{table}]\ninterface = "{EMULATED}"\nchannel = "127.0.0.1:{hub.port}"\nbitrate = {hub.bitrate}'
            for table, hub in zip(("bus", "bus2"), hubs, strict=False)
        )
        say(f"{len(emulator.drives)} drives, standing where {made.task.name} begins. In the network file:\n{told}")
        serve(emulator, hubs)
    except KeyboardInterrupt:
        return 0
    finally:
        for hub in hubs:
            hub.close()
    return 0
