"""What a browser may have written: below the folder that was opened only, and over nothing that was not seen."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from workbench_makers import LONG, small

import hognose
from hognose.errors import InputError
from hognose.viewer.model import edits
from hognose.viewer.model.saving import below, digest, file_stem
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.opening import opened


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a folder in it, beside one that is none of our business, and links from the one into the other."""
    around = tmp_path_factory.mktemp("around")
    here, other = around / "here", around / "other"
    (here / "sub").mkdir(parents=True)
    other.mkdir()
    (here / "out").symlink_to(other)
    (here / "out.toml").symlink_to(other / "new.toml")
    (here / "out.parquet").symlink_to(other / "new.parquet")
    (here / "in.toml").symlink_to("sub/real.toml")
    (here / "round.toml").symlink_to("round.toml")
    return here


@pytest.fixture
def bench(folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Workbench]:
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path))
    with Workbench(small(), folder=folder) as made:
        yield made


LEADS_OUT = [
    "../x.toml",
    "sub/../../x.toml",
    "sub/../x.toml",
    "..\\x.toml",
    "/x.toml",
    "//x/y.toml",
    "out/x.toml",
    "out/sub/x.toml",
    "out.toml",
]
NO_NAME = ["", " ", ".", "..", "/", "sub/", "sub/.", "sub/..", "a\\"]
NO_FILE = ["a\0b.toml", "\0", "a\nb.toml", "\x1b[2J.toml", "a\ud800.toml", "a\x7f.toml"]
TOO_LONG = ["x" * 251 + ".toml", "sub/" + "ä" * 126 + ".toml", "/".join(["x" * 100] * 11) + ".toml", "x" * 100_000]


@pytest.mark.parametrize("name", LEADS_OUT + NO_NAME + NO_FILE + TOO_LONG)
def test_such_names_are_answered_and_nothing_is_written(bench, folder, name):
    before = everything(folder)
    for write in (bench.save, bench.save_plan):
        for force in (False, True):
            with pytest.raises(InputError) as refused:
                write(name, force)
            assert str(refused.value).isprintable()
            assert len(str(refused.value)) < 600
    assert everything(folder) == before


def everything(folder: Path) -> list[Path]:
    return sorted(folder.parent.rglob("*"))


@pytest.mark.parametrize("name", LEADS_OUT)
def test_the_folder_is_named_where_a_name_leads_out_of_it(folder, name):
    with pytest.raises(InputError, match=rf"within {folder.resolve()}, the folder that was opened"):
        below(folder, name)


def test_a_plan_does_not_follow_a_link_of_its_own_name_out_of_the_folder(bench):
    with pytest.raises(InputError, match=r"leads to .*other.new\.parquet"):
        bench.save_plan("out.toml")
    with pytest.raises(InputError, match=r"leads to .*other.new\.parquet"):
        bench.save_plan("out.parquet")


def test_links_in_a_circle_lead_nowhere(bench):
    with pytest.raises(InputError, match=r"leads to .*round\.toml"):
        bench.save("round.toml")


def test_names_below_the_folder_are_taken(folder):
    assert below(folder, " mine.toml ") == folder.resolve() / "mine.toml"
    assert below(folder, "sub/mine.toml") == folder.resolve() / "sub" / "mine.toml"
    assert below(folder, "in.toml") == folder.resolve() / "sub" / "real.toml"
    assert below(folder, "..x.toml", ".parquet") == folder.resolve() / "..x.parquet"


@given(st.text() | st.text("./\\\0ab~:" + "ä", max_size=12))
@settings(max_examples=300, deadline=None)
def test_whatever_the_name_what_comes_out_is_below_or_an_error(folder, name):
    for suffix in (None, ".parquet"):
        try:
            file = below(folder, name, suffix)
        except InputError:
            continue
        assert file.is_relative_to(folder.resolve())
        assert file != folder.resolve()
        assert not file.is_symlink()
        assert len(os.fsencode(file.name)) <= 258


@given(st.text(min_size=1, max_size=80))
def test_a_tasks_name_is_the_beginning_of_a_files(name):
    stem = file_stem(name)
    assert 0 < len(stem.encode()) <= 200
    assert all(c.isalnum() or c == "-" for c in stem)


def test_a_plan_is_written_over_only_as_it_was_read_or_written(tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    file = tmp_path / "plan.parquet"
    with Workbench(small(), folder=tmp_path) as bench:
        bench.save_plan("plan.toml")
        bench.edit(edits.set_margin(0.001))
        bench.save_plan("plan.toml")  # its own
        assert hognose.Plan.load(file).task.margin == 0.001
        for content in (b"somebody else's", b""):
            file.write_bytes(content)
            with pytest.raises(InputError, match=r"has changed on disk since .* allow overwriting"):
                bench.save_plan("plan.toml")
            assert file.read_bytes() == content
        bench.save_plan("plan.toml", force=True)
        bench.save_plan("plan.toml")
        (tmp_path / "other.parquet").write_bytes(b"precious")
        with pytest.raises(InputError, match="exists already"):
            bench.save_plan("other")
        assert (tmp_path / "other.parquet").read_bytes() == b"precious"
        file.unlink()
        bench.save_plan("plan.toml")  # nothing there to be lost
    with Workbench(small(), folder=tmp_path, seen={file: digest(file)}) as bench:  # it was opened
        bench.save_plan("plan.toml")
    with Workbench(small(), folder=tmp_path) as bench, pytest.raises(InputError, match="exists already"):
        bench.save_plan("plan.toml")


def test_the_plan_that_is_saved_is_that_of_the_version_that_was_there(tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    with Workbench(small(), folder=tmp_path) as bench:
        verdict = bench.settle(LONG)
        wait = bench._replanner.settle

        def edited_meanwhile(number: int, timeout: float) -> object:
            bench.edit(edits.set_margin(0.002))
            return wait(number + 1, timeout)

        monkeypatch.setattr(bench._replanner, "settle", edited_meanwhile)
        with pytest.raises(InputError, match="edited before it was planned"):
            bench.save_plan("plan")
        assert not (tmp_path / "plan.parquet").exists()
        assert bench.verdict is not verdict


def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(bench, folder):
    for name in ("pipe.toml", "pipe.parquet"):
        os.mkfifo(folder / name)
        for force in (False, True):
            with pytest.raises(InputError, match=r"regular file|exists already"):
                (bench.save if name.endswith("toml") else bench.save_plan)(name, force)
        (folder / name).unlink()


def test_drafts_are_their_owners_only(tmp_path, monkeypatch):
    cache = tmp_path / "cache"
    monkeypatch.setenv("HOGNOSE_CACHE", str(cache))
    (cache / "drafts").mkdir(parents=True)
    (cache / "drafts").chmod(0o755)  # as one of an older version may be
    mask = os.umask(0)
    try:
        for margin in (0.001, 0.002):  # written, and written over
            with Workbench(small()) as bench:
                bench.edit(edits.set_margin(margin))
            (draft,) = (cache / "drafts").iterdir()
            assert stat.S_IMODE(draft.stat().st_mode) == 0o600
            assert stat.S_IMODE((cache / "drafts").stat().st_mode) == 0o700
            draft.chmod(0o644)
    finally:
        os.umask(mask)


def test_what_is_opened_tells_where_files_are_written(tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    there, here = tmp_path / "there", tmp_path / "here"
    there.mkdir()
    here.mkdir()
    monkeypatch.chdir(here)
    hognose.plan(small()).save(there / "plan.parquet")
    with opened("../there/plan.parquet", port=0) as page:
        assert page.bench is not None
        assert page.bench.folder.resolve() == there
        page.bench.save_plan("plan.parquet")  # as it was opened
        page.bench.save("mine.toml")
    with opened(str(there / "mine.toml"), port=0) as page:
        assert page.bench is not None
        assert page.editing._file.value == "mine.toml"
        page.bench.save(page.editing._file.value)
    with opened("detour", port=0) as page:
        assert page.bench is not None
        page.bench.save(page.editing._file.value)
    assert sorted(file.name for file in tmp_path.rglob("*.*")) == ["detour.toml", "mine.toml", "plan.parquet"]
