"""`hognose view`."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from typing import Annotated

from cyclopts import Parameter

from hognose.cli.options import Flag, Shown


def view(
    source: Shown,
    /,
    *,
    port: int = 8080,
    host: str = "127.0.0.1",
    browser: Annotated[bool, Parameter(negative="--no-browser")] = True,
    json: Flag = False,
) -> int:
    """Open a page in the browser to view and edit a task, a plan, a robot or a space, and to steer the arm.

    Parameters
    ----------
    source
        A task (name or .toml), a plan (.parquet), a robot (name or .toml), or a mesh, STEP or point file.
    port
        Port of the page; if it is in use, the next free one.
    host
        Address on which the page is served. If it can be reached from other machines, anyone with the printed link may
        edit.
    browser
        Open the page in the browser.
    json
        Print the address as JSON.
    """
    import webbrowser

    from hognose.cli import compile_ahead
    from hognose.cli.console import say, say_json
    from hognose.viewer.opening import opened
    from hognose.viewer.server.redirect import redirect_file

    compile_ahead.when_needed()
    with opened(source, host, port) as page:
        if json:
            say_json({"url": page.address.url, "host": page.address.host, "port": page.address.port})
        else:
            if host not in ("127.0.0.1", "localhost", "::1"):
                say(f"note: {host} can be reached from other machines; whoever has this link may edit")
            say(f"{page.address.url}\nCtrl-C ends it")
        sys.stdout.flush()
        try:
            with redirect_file(page.address.url) if browser else nullcontext() as file:
                if file is not None:
                    page.server.on_client_connect(lambda _: file.unlink(missing_ok=True))
                    webbrowser.open(file.as_uri())
                page.run()
        except KeyboardInterrupt:
            if not json:
                say("; ".join(filter(None, ("ended", page.left()))))
    return 0
