"""`hognose methods`."""

from __future__ import annotations

from collections.abc import Mapping

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
    from hognose.following import METHODS, OF_SECTIONS

    def described(methods: Mapping[str, type]) -> dict[str, str]:
        return {name: (inspect.getdoc(method) or "").splitlines()[0] for name, method in methods.items()}

    links, others = described(METHODS), described(OF_SECTIONS)
    if json:
        say_json({"default": next(iter(METHODS)), "methods": links, "of_other_sections": others})
    else:
        table(("method", "what it does"), [[name, text] for name, text in links.items()])
        rows = [[name, text] for name, text in others.items()]
        table(("method", "what it does of sections that are no rigid links"), rows)
    return 0
