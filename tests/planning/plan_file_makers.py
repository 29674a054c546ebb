"""Plan files as another program would write them: with other columns, other metadata, and digests of its own or not."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

SAID, DIGESTS = b"hognose", b"hognose.sha256"
Entries = dict[bytes, bytes]


def rewritten(
    file: Path,
    change_table: Callable[[Any], Any] | None = None,
    change_meta: Callable[[Any], Any] | None = None,
    *,
    sealed: bool = True,
    change_entries: Callable[[Entries], object] | None = None,
) -> bytes:
    """A plan file with another table or other metadata; `sealed` with new digests, as a forger would."""
    table, held = pq.read_table(file), dict(pq.ParquetFile(file).metadata.metadata)
    del held[b"ARROW:schema"]
    if change_table:
        table = change_table(table)
    if change_meta:
        said = change_meta(json.loads(held[SAID]))
        held[SAID] = said if isinstance(said, bytes) else json.dumps(said).encode()
    if sealed:
        held[DIGESTS] = json.dumps(digests(table, held[SAID])).encode()
    if change_entries:
        change_entries(held)
    sink = pa.BufferOutputStream()
    pq.write_table(table.replace_schema_metadata(held), sink)
    return sink.getvalue().to_pybytes()


def digests(table: Any, said: bytes) -> dict[str, Any]:
    """As docs/plan-file.md says."""
    columns = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        values = column.to_numpy(zero_copy_only=False)
        if values.dtype.kind in "if":
            raw = values.astype(f"<{values.dtype.kind}8").tobytes()
        else:
            texts = [str(value).encode() for value in values]
            raw = b"".join(len(text).to_bytes(8, "little") + text for text in texts)
        columns[name] = hashlib.sha256(raw).hexdigest()
    return {"hognose": hashlib.sha256(said).hexdigest(), "columns": columns}


def at(dotted: str, value: Any) -> Callable[[Any], Any]:
    """A change of the metadata: another value at a dotted key, or a function of the old one; `...` deletes it."""

    def change(said: Any) -> Any:
        *way, last = (int(key) if key.isdigit() else key for key in dotted.split("."))
        place = said
        for key in way:
            place = place[key]
        if value is ...:
            del place[last]
        else:
            place[last] = value(place[last]) if callable(value) else value
        return said

    return change


def replaced(name: str, values: Callable[[np.ndarray], Any], called: str | None = None) -> Callable[[Any], Any]:
    """A change of the table: another column (an array of Arrow or NumPy, made of the old one) in a column's place."""

    def change(table: Any) -> Any:
        made = values(table.column(name).to_numpy().copy())
        column = made if isinstance(made, pa.Array | pa.DictionaryArray) else pa.array(made)
        return table.set_column(table.column_names.index(name), called or name, column)

    return change
