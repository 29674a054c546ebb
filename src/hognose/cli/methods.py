"""`hognose methods`."""

from __future__ import annotations

from hognose.cli.options import Flag


def methods(*, json: Flag = False) -> int:
    """List the following methods.

    Parameters
    ----------
    json
        Print the list as JSON.
    """
    import inspect

    from hognose.cli.console import say_json, table
    from hognose.following import METHODS

    described = {name: (inspect.getdoc(method) or "").splitlines()[0] for name, method in METHODS.items()}
    if json:
        say_json({"default": next(iter(METHODS)), "methods": described})
    else:
        table(("method", "what it does"), [[name, text] for name, text in described.items()])
    return 0
