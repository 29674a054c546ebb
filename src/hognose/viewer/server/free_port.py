"""A socket on the port that is asked for, or the next that is free."""

from __future__ import annotations

import errno
import socket

from hognose.errors import InputError

#: How many ports are tried, from the one asked for; as many as viser would.
TRIES = 1000


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens on the port or the next that is free.

    It is made here and not by viser, which tries a thousand ports where the host is wrong, and then hangs.
    """
    if not host or not 0 <= port <= 65535:
        raise InputError(f"the viewer cannot listen on '{host}', port {port}; give a host and a port of 0 to 65535")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    last = min(port + TRIES, 65536) - 1
    for candidate in range(port, last + 1):
        try:
            return socket.create_server((host, candidate), family=family)
        except OSError as error:
            # Windows denies ports that it keeps for itself; elsewhere only those below 1024 are denied.
            if error.errno == errno.EADDRINUSE or (error.errno == errno.EACCES and candidate >= 1024):
                continue
            raise InputError(
                f"the viewer cannot listen on '{host}', port {candidate}: {error.strerror}; "
                "give an address of this machine, such as 127.0.0.1, and a port above 1023"
            ) from None
    raise InputError(f"the ports {port} to {last} of '{host}' are all taken; give another, or 0 for any that is free")
