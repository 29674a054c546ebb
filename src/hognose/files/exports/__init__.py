"""Plans in the formats of other programs: one file a format."""

from __future__ import annotations

from pathlib import Path

from hognose.arguments import file_name, instance
from hognose.errors import HognoseError, InputError
from hognose.extensions import added, words_of
from hognose.files.exports import csv, json, parquet
from hognose.files.exports.format import Export
from hognose.planning.plan import Plan
from hognose.write_whole import write_whole

__all__ = ["Export", "export", "formats"]

#: The formats that Hognose has.
_BUNDLED = {"csv": csv.EXPORT, "json": json.EXPORT, "parquet": parquet.EXPORT}


def formats() -> dict[str, Export]:
    """All formats by suffix: those of Hognose, and those that other packages add under `hognose.exports`.

    Raises
    ------
    InputError
        What a package adds is no `Export`, or has the suffix of another.
    """
    found: dict[str, tuple[str, Export]] = {}
    for name, given in [*_BUNDLED.items(), *added("exports").items()]:
        if not isinstance(given, Export):
            raise InputError(
                f"hognose.exports: {name!r} is {type(given).__name__}, expected a "
                "hognose.files.exports.Export; mend or uninstall the package that adds it"
            )
        if given.suffix in found:
            raise InputError(
                f"hognose.exports: {found[given.suffix][0]!r} and {name!r} both write {given.suffix}; uninstall the "
                "package that adds one of them"
            )
        found[given.suffix] = (name, given)
    return {suffix: given for suffix, (_, given) in found.items()}


def export(plan: Plan, path: Path | str) -> Plan:
    """Verify a plan and write it in the format its suffix names.

    Returns
    -------
    Plan
        The plan as it was written, with its new verdict, good or not: what fails is written as such.

    Raises
    ------
    InputError
        Unknown suffix, a format that fails, or the file cannot be written.
    """
    instance("plan", plan, Plan, "a hognose.Plan")
    path = file_name("path", path)
    known = formats()
    chosen = known.get(path.suffix.lower())
    if chosen is None:
        raise InputError(f"{path}: unknown format {path.suffix!r}; expected {', '.join(known)}")
    verified = plan.verified()
    write_whole(path, _written(chosen, verified))
    return verified


def _written(chosen: Export, plan: Plan) -> bytes:
    if chosen in _BUNDLED.values():
        return chosen.write(plan)
    foreign = f"the format {chosen.suffix}, which another package adds,"
    try:
        content = chosen.write(plan)
    except HognoseError:
        raise
    except (Exception, SystemExit) as error:
        raise InputError(f"{foreign} fails: {words_of(error)}") from error
    if not isinstance(content, bytes):
        raise InputError(f"{foreign} made {type(content).__name__}, expected bytes")
    return content
