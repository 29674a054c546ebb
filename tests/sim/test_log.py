"""The log of a simulation, in all formats and to all ends."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from twin_makers import boards, shortened

from hognose.errors import InputError
from hognose.sim import Changes, SimulationInterrupted, simulate, write_log
from hognose.sim.log import COLUMNS, METADATA_KEY, cells, refuse_log

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def touching():
    return simulate(boards(), Changes(shifted={"board 2": (0.0, 0.045, 0.0)}), stop_at_contact=5.0)


def test_all_formats_hold_the_same(touching, tmp_path):
    columns = cells(touching)
    for suffix in (".csv", ".parquet", ".json"):
        write_log(touching, tmp_path / f"log{suffix}")
    rows = list(csv.reader(io.StringIO((tmp_path / "log.csv").read_text())))
    assert rows[0] == list(columns)
    assert len(rows) == len(touching.time) + 1
    table, said = pq.read_table(tmp_path / "log.parquet"), json.loads((tmp_path / "log.json").read_text())
    assert table.column_names == list(columns)
    for k, (name, values) in enumerate(columns.items()):
        assert table[name].to_pylist() == values.tolist() == said["columns"][name]
        kind = str if values.dtype == object else float
        assert [kind(row[k]) for row in rows[1:]] == values.tolist()
    meta = json.loads(table.schema.metadata[METADATA_KEY])
    assert meta == said["hognose"]
    assert meta["changes"]["shifted_m"] == {"board 2": [0.0, 0.045, 0.0]}
    assert meta["contact_stop"]["link"] == 12


def test_rows_say_what_happened(touching):
    columns, done = cells(touching), touching
    first = int(np.searchsorted(done.time, done.first_contact))
    pressed = np.array([columns[f"contact_{link:02d}_N"] for link in range(1, 13)])
    names = np.array([columns[f"contact_{link:02d}_obstacle"] for link in range(1, 13)])
    assert not pressed[:, :first].any()
    assert pressed[:, first].any()
    assert set(names.ravel()) == {"", "board 2"}
    np.testing.assert_array_equal(names != "", pressed > 0)
    tips = [np.array([columns[f"{kind}_{axis}_m"] for axis in "xyz"]) for kind in ("planned_tip", "tip")]
    np.testing.assert_allclose(np.linalg.norm(tips[1] - tips[0], axis=0), columns["tip_error_m"], atol=1e-15)
    np.testing.assert_array_equal(columns["tension_36_N"], done.tensions[:, 35])
    np.testing.assert_array_equal(columns["reached_beta_03_rad"], done.angles[:, 2, 1])
    np.testing.assert_allclose(columns["time_s"][:100], boards().time[:100])


def test_the_page_lists_every_column():
    page = (ROOT / "docs" / "twin.md").read_text()
    for each in COLUMNS:
        assert f"`{each.shown}`" in page
        assert each.meaning in page


@pytest.mark.parametrize("at", [1, 7])
def test_what_was_done_is_kept_when_it_is_interrupted(at):
    def interrupt(done: int, total: int) -> None:
        assert total == 20
        if done == at:
            raise KeyboardInterrupt

    with pytest.raises(SimulationInterrupted, match=f"obstacle array: period {at}: interrupted") as caught:
        simulate(shortened(boards(), 20), progress=interrupt)
    done, whole = caught.value.done, simulate(shortened(boards(), 20))
    assert len(done.time) == at + 1
    assert not done.good
    np.testing.assert_array_equal(done.joints, whole.joints[: at + 1])


def test_a_file_that_cannot_be_written_is_refused_at_once(touching, tmp_path):
    with pytest.raises(InputError, match=r"unknown format '.txt' of a log; expected .csv, .parquet, .json"):
        refuse_log(tmp_path / "log.txt")
    with pytest.raises(InputError, match="there is no folder"):
        write_log(touching, tmp_path / "nowhere" / "log.csv")
    assert list(tmp_path.iterdir()) == []
