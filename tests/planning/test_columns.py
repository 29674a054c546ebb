"""Columns are declared once: files, exports and documentation are made from that, and anybody can declare more."""

from __future__ import annotations

import dataclasses
import runpy
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from plan_file_makers import replaced, rewritten
from planning_makers import assert_same_cells, random_robot

import hognose
from hognose.files import export
from hognose.planning import Plan
from hognose.planning.columns import QUANTITIES, Column, Quantity, cells_of, columns_of
from hognose.planning.motion import Motion

DOCS = Path(__file__).parents[2] / "docs"
#: Patterns of our columns, in the order of the file. More may be added.
OURS = (
    "time_s", "feed_m", "joint_{joint}_{xyz}_m", "{angle}_{section}_rad", "cable_{cable}_m", "motor_{cable}_counts",
    "clearance_{link}_m", "deviation_{link}_m",
)  # fmt: skip


def test_the_table_of_the_documentation_is_made_from_the_declarations():
    made = runpy.run_path(str(DOCS / "plan_columns.py"))
    page = (DOCS / "plan-file.md").read_text(encoding="utf-8")
    assert made["with_table"](page) == page, "run: python docs/plan_columns.py"
    assert made["table"]().count("\n") == len(QUANTITIES) + 2


@pytest.mark.parametrize("sections", [1, 2, 9, 10, 100, 101])
def test_every_cell_has_one_column(sections):
    robot = random_robot(np.random.default_rng(sections), sections)
    columns = columns_of(robot)
    assert len({column.name for column in columns}) == len(columns)
    for quantity in QUANTITIES:
        places = [column.place for column in columns if column.quantity is quantity]
        assert sorted(places) == list(np.ndindex(quantity.shape(robot)))
    assert tuple(quantity.pattern for quantity in QUANTITIES if quantity.pattern in OURS) == OURS
    of_ours = sum(column.quantity.pattern in OURS for column in columns)
    assert of_ours == 2 + 3 * (sections + 1) + 2 * sections + 2 * robot.cables + 2 * sections


def test_what_is_stored_makes_the_motion(boards):
    stored = {str(quantity.of) for quantity in QUANTITIES if quantity.stored}
    needed = {each.name for each in dataclasses.fields(Motion) if each.default is each.default_factory}
    assert stored == needed - {"task", "way_points"} | {"base_pose"}  # where there is a carrier
    cells = cells_of(boards)
    for column in columns_of(boards.robot):
        of = column.quantity.of
        whole = getattr(boards, of) if isinstance(of, str) else of(boards)
        if of == "base_pose":
            assert whole is None
            continue
        assert whole is not None
        assert np.array_equal(cells[column.name], whole[(slice(None), *column.place)])


@pytest.fixture
def declared() -> Iterator[list[Quantity]]:
    """The declarations, for a test to add to."""
    before = list(QUANTITIES)
    yield QUANTITIES
    QUANTITIES[:] = before


def bends(motion: Motion) -> np.ndarray:
    return np.arccos(np.cos(motion.angles).prod(axis=2))


BEND = Quantity("total_bend_{section}_rad", "rad", "bend angle by section", bends, ("section",))


def test_a_script_adds_a_column_to_all_formats(declared, boards, tmp_path):
    declared.append(BEND)
    boards.save(tmp_path / "plan.parquet")
    for file in ("plan.csv", "plan.json"):
        export(boards, tmp_path / file)
    names = [f"total_bend_{k:02d}_rad" for k in range(1, 13)]
    frame = pd.read_parquet(tmp_path / "plan.parquet")
    assert list(frame.columns[-12:]) == names
    np.testing.assert_array_equal(frame[names], bends(boards))
    assert list(pd.read_csv(tmp_path / "plan.csv").columns[-12:]) == names
    assert '"total_bend_12_rad": [' in (tmp_path / "plan.json").read_text()
    read = Plan.load(tmp_path / "plan.parquet")
    assert_same_cells(read, boards)
    assert not read.extra
    read.save(tmp_path / "again.parquet")
    assert (tmp_path / "again.parquet").read_bytes() == (tmp_path / "plan.parquet").read_bytes()


def test_an_added_column_is_held_against_the_plan_by_who_declares_it_and_kept_by_others(declared, boards, tmp_path):
    declared.append(BEND)
    boards.save(tmp_path / "plan.parquet")
    changed = rewritten(tmp_path / "plan.parquet", replaced("total_bend_07_rad", lambda values: values + 1e-6))
    (tmp_path / "changed.parquet").write_bytes(changed)
    with pytest.raises(hognose.InputError, match=r"column 'total_bend_07_rad' is 1e-06 rad off at step \d+ from what"):
        Plan.load(tmp_path / "changed.parquet")
    declared.pop()
    read = Plan.load(tmp_path / "changed.parquet")
    assert list(read.extra) == [f"total_bend_{k:02d}_rad" for k in range(1, 13)]
    assert "12 columns that Hognose does not know are kept" in read.summary()


def test_files_may_lack_an_added_column_but_not_a_part_of_it(declared, boards, tmp_path):
    boards.save(tmp_path / "before.parquet")
    declared.append(BEND)
    assert_same_cells(Plan.load(tmp_path / "before.parquet"), boards)
    boards.save(tmp_path / "plan.parquet")
    part = rewritten(tmp_path / "plan.parquet", lambda table: table.drop_columns(["total_bend_07_rad"]))
    (tmp_path / "part.parquet").write_bytes(part)
    with pytest.raises(hognose.InputError, match="column 'total_bend_07_rad' is missing"):
        Plan.load(tmp_path / "part.parquet")


def test_a_robot_without_such_a_thing_has_no_such_columns(declared, boards, tmp_path):
    """Stresses, say, of arms whose mechanics are known."""
    declared.append(
        Quantity(
            "stress_{cable}_N", "N", "cable stresss",
            lambda motion: None if motion.retracts else 2.0 + motion.cable_lengths, ("cable",), tolerance=1e-6,
        )
    )  # fmt: skip
    boards.save(tmp_path / "there.parquet")
    assert "stress_36_N" in pq.read_schema(tmp_path / "there.parquet").names
    assert_same_cells(Plan.load(tmp_path / "there.parquet"), boards)
    back = hognose.planning.retraction(boards)
    back.save(tmp_path / "gone.parquet")
    assert not [name for name in pq.read_schema(tmp_path / "gone.parquet").names if name.startswith("stress")]
    assert_same_cells(Plan.load(tmp_path / "gone.parquet"), back)

    def with_one(table):
        for k in range(1, 37):
            table = table.append_column(f"stress_{k:02d}_N", table["cable_01_m"])
        return table

    (tmp_path / "invented.parquet").write_bytes(rewritten(tmp_path / "gone.parquet", with_one))
    with pytest.raises(hognose.InputError, match="column 'stress_01_N' is inf N off"):
        Plan.load(tmp_path / "invented.parquet")


@pytest.fixture
def package(monkeypatch):
    """Have an installed package name quantities under `hognose.columns`, by the names of its entries."""

    def add(**entries: object) -> None:
        monkeypatch.setattr("hognose.planning.columns.added", lambda group: {"columns": entries}[group])
        monkeypatch.setattr("hognose.planning.columns.package_of", lambda group, name: f"{name}-{group}")

    return add


@pytest.mark.parametrize("as_list", [False, True])
def test_a_package_adds_a_column_that_is_known_before_any_file_is_read(package, boards, tmp_path, as_list):
    before = list(cells_of(boards))
    package(mine=[BEND] if as_list else BEND)
    assert list(cells_of(boards)) == [*before, *(f"total_bend_{k:02d}_rad" for k in range(1, 13))]
    boards.save(tmp_path / "plan.parquet")
    read = Plan.load(tmp_path / "plan.parquet")
    assert not read.extra
    assert_same_cells(read, boards)
    package()
    without = Plan.load(tmp_path / "plan.parquet")
    assert len(without.extra) == 12
    package(mine=BEND)
    assert "does not know" not in without.summary()
    without.save(tmp_path / "again.parquet")
    assert (tmp_path / "again.parquet").read_bytes() == (tmp_path / "plan.parquet").read_bytes()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (3, r"expected a hognose\.planning\.columns\.Quantity, or a list of them, got int"),
        ([BEND, 3], r"item 2: expected a hognose\.planning\.columns\.Quantity"),
        (iter([BEND]), "or a list of them, got list_iterator"),
        (dataclasses.replace(BEND, since=2), "declared with stored or since"),
        (Quantity("mine_m", "m", "mine", "feed", stored=True), "declared with stored or since"),
    ],
)
def test_what_a_package_may_not_add_names_it(package, boards, wrong, said):
    package(mine=wrong)
    home = r"^the entry 'mine' of hognose\.columns in the package mine-columns: "
    with pytest.raises(hognose.InputError, match=home + ".*" + said):
        cells_of(boards)


def test_a_column_of_a_package_that_fails_or_is_there_already_names_it(package, boards):
    package(mine=dataclasses.replace(BEND, of=lambda motion: 1 / 0))
    with pytest.raises(
        hognose.InputError, match=r"take the quantity out of the entry 'mine' of hognose\.columns in the"
    ):
        cells_of(boards)
    package(mine=Quantity("feed_m", "m", "mine", "feed"))
    with pytest.raises(hognose.InputError, match=r"'feed_m' from .*QUANTITIES and 'feed_m' from the entry 'mine' of"):
        cells_of(boards)


def with_extra(plan: Plan, cells: object) -> Plan:
    return dataclasses.replace(plan, extra={"total_bend_07_rad": cells, "note": ["a"] * len(plan.time)})


def test_a_further_column_that_became_known_is_taken_as_known(declared, boards, tmp_path):
    plan = with_extra(boards, bends(boards)[:, 6])
    assert "2 columns that Hognose does not know" in plan.summary()
    declared.append(BEND)
    assert "1 column that Hognose does not know is kept: note" in plan.summary()
    plan.save(tmp_path / "plan.parquet")
    assert list(Plan.load(tmp_path / "plan.parquet").extra) == ["note"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda cells: cells + 1e-6 * (np.arange(len(cells)) == 9),
            "is 1e-06 rad off at step 9 from what the plan gives",
        ),
        (lambda cells: cells * np.nan, "is nan rad off at step 0"),
        (lambda cells: cells[1:], r"but holds float64 \(312,\): expected float64 \(313,\)"),
        (lambda cells: cells.astype(str), r"but holds <U\d+ \(313,\): expected"),
    ],
)
def test_one_whose_figures_are_others_is_refused_and_named(declared, boards, tmp_path, change, said):
    plan = with_extra(boards, change(bends(boards)[:, 6]))
    declared.append(BEND)
    with pytest.raises(
        hognose.InputError, match=r"^column 'total_bend_07_rad' of `extra` is known as one of .*" + said
    ):
        plan.save(tmp_path / "plan.parquet")
    declared[-1] = dataclasses.replace(BEND, of=lambda motion: None)
    with pytest.raises(hognose.InputError, match="of which this plan has no figures"):
        plan.save(tmp_path / "plan.parquet")
    assert not list(tmp_path.iterdir())


WRONG = {
    "another shape": lambda motion: motion.angles,
    "another type": lambda motion: motion.clearance.astype(np.float32),
    "fewer rows": lambda motion: motion.clearance[1:],
    "a list": lambda motion: motion.clearance.tolist(),
    "not finite": lambda motion: motion.clearance * np.nan,
    "too large": lambda motion: motion.clearance * 1e9,
}


@pytest.mark.parametrize("kind", list(WRONG))
def test_figures_that_are_not_what_was_declared_are_not_written(declared, boards, tmp_path, kind):
    declared.append(Quantity("mine_{link}_m", "m", "mine", WRONG[kind], ("link",)))
    with pytest.raises(hognose.InputError, match="mine_"):
        boards.save(tmp_path / "plan.parquet")
    assert not list(tmp_path.iterdir())


def test_two_quantities_of_one_name_are_refused(declared, boards):
    declared.append(Quantity("cable_{section}_m", "m", "mine", "clearance", ("section",)))
    with pytest.raises(
        hognose.InputError,
        match=r"two quantities have a column 'cable_01_m': 'cable_\{cable\}_m' from .*QUANTITIES and",
    ):
        columns_of(boards.robot)


@pytest.mark.parametrize(
    ("pattern", "each"),
    [("mine_m", ("link",)), ("mine_{link}_m", ()), ("mine_{link}_{link}_m", ("link",)), ("mine_{door}_m", ("door",))],
)
def test_a_pattern_names_each_axis_once(pattern, each):
    with pytest.raises(hognose.InputError, match=r"expected \{…\} around each of"):
        Quantity(pattern, "m", "mine", "clearance", each)


def test_what_is_stored_is_an_attribute():
    with pytest.raises(hognose.InputError, match="is an attribute of Motion"):
        Quantity("mine_m", "m", "mine", lambda motion: motion.feed, stored=True)


def test_a_column_knows_its_place():
    robot = hognose.load_robot("sjtu-25dof")
    column = next(column for column in columns_of(robot) if column.name == "beta_03_rad")
    assert (column.quantity.of, column.place) == ("angles", (2, 1))
    assert column == Column("beta_03_rad", column.quantity, (2, 1))
