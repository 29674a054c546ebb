"""What is said and asked where drives are there, and not emulated: they move people's machines."""

from __future__ import annotations

from hognose.drive.network import Network
from hognose.drive.network_spec import EMULATED
from hognose.errors import InputError

#: Where emulated drives are reached: on this machine.
_HERE = ("127.0.0.1:", "localhost:")


def real_interfaces(network: Network) -> list[str]:
    """The interfaces and ports of drives that are there, not emulated on this machine."""
    slider, found = network.spec.slider, []
    for bus in network.spec.buses:
        if bus.interface != EMULATED:
            found.append(bus.interface)
        elif bus.channel and not (bus.channel.startswith(_HERE)):
            found.append(bus.channel)
    if slider is not None and slider.kind == "serial" and not slider.port.startswith("socket://127.0.0.1:"):
        found.append(slider.port)
    return found


def refuse_unattended(network: Network, yes: bool) -> None:
    """Raise an InputError if drives are there, and nobody is to be asked."""
    if yes and (real := real_interfaces(network)):
        raise InputError(
            f"{network.source}: drives on {' and '.join(real)} are not emulated: they do something only after a "
            "confirmation at a terminal, without --yes"
        )


def untested(network: Network) -> str:
    """What is to be said, where drives are there, before they do anything; empty where they are emulated."""
    if not (real := real_interfaces(network)):
        return ""
    return (
        f"The drives on {' and '.join(real)} are real, and no version of Hognose has been tested on hardware: know "
        "where the emergency stop is, and take the steps of docs/connect.md, First motion. "
    )
