import importlib.util
import inspect
import re
import runpy
import shlex
import shutil
import subprocess
from html import unescape

import numpy as np
import pytest
import trimesh
from docs_pages import DOCS, PAGES, ROOT, blocks, build, pages_with, write_files_of

import hognose
from hognose.cli import main
from hognose.drive.network import load_network
from hognose.files import with_method
from hognose.following import METHODS, Follower
from hognose.planning import TaskSpec
from hognose.planning.checks import ALL
from hognose.robot import RobotSpec
from hognose.units import FileModel

REFERENCE = runpy.run_path(str(DOCS / "file_reference.py"))
FILES = {"robot-file": RobotSpec, "task-file": TaskSpec}


def by_name(page):
    return str(page.relative_to(ROOT))


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The site with a page more, whose links lead nowhere, and what building it said: one build, for it takes long."""
    folder = tmp_path_factory.mktemp("site")
    for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md"):
        shutil.copy(ROOT / name, folder)
    docs = shutil.copytree(DOCS, folder / "docs", ignore=shutil.ignore_patterns("_build", "__pycache__"))
    (docs / "astray.md").write_text(
        "---\norphan: true\n---\n\n# Astray\n\n[a page](no-such-page.md), [a heading](certificate.md#no-such-heading)\n"
    )
    return folder / "html", build(docs, folder / "html")


@pytest.fixture(scope="module")
def site(built):
    return built[0]


def test_the_site_has_every_page(site):
    for page in PAGES:
        assert (site / page.relative_to(DOCS).with_suffix(".html")).is_file(), page
    assert "What it assumes" in (site / "certificate.html").read_text()
    assert "Many values are assumed." in (site / "limitations.html").read_text()
    assert "Keep a Changelog" in (site / "changelog.html").read_text()
    assert "Where things go." in (site / "contributing.html").read_text()


def test_links_that_lead_nowhere_fail_the_build_and_nothing_else_does(built):
    done = built[1]
    assert done.returncode == 1
    warned = [line for line in done.stderr.splitlines() if re.search(r"WARNING|ERROR|CRITICAL", line)]
    assert len(warned) == 2, done.stderr
    for line, astray in zip(warned, ("no-such-page", "no-such-heading"), strict=True):
        assert "astray.md" in line
        assert astray in line


@pytest.fixture(scope="module")
def planned(boards, tmp_path_factory):
    """What `hognose plan obstacle-array` writes, for pages about plan files."""
    file = tmp_path_factory.mktemp("planned") / "obstacle-array.parquet"
    boards.save(file)
    return file


@pytest.mark.parametrize("page", pages_with("python"), ids=by_name)
def test_the_python_on_a_page_runs(page, planned, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    write_files_of(page, tmp_path)
    shutil.copy(planned, tmp_path)
    script = tmp_path / "page.py"
    script.write_text("\n".join(blocks(page, "python")), encoding="utf-8")
    exec(compile(script.read_text(encoding="utf-8"), str(script), "exec"), {"__name__": "page"})


@pytest.mark.parametrize("page", pages_with("toml"), ids=by_name)
def test_the_files_on_a_page_are_read(page, tmp_path):
    shutil.copy(ROOT / "examples" / "step_tank.step", tmp_path / "vessel.step")
    for text in blocks(page, "toml"):
        file = tmp_path / "file.toml"
        file.write_text(text, encoding="utf-8")
        if "[[section]]" in text:
            hognose.load_robot(file)
        elif "[bus]" in text:
            load_network(file)
        else:
            hognose.load_task(file)


@pytest.mark.parametrize(
    ("page", "count"),
    [
        (ROOT / "README.md", 8),
        (DOCS / "first-plan.md", 5),
        (DOCS / "your-own-space.md", 6),
        (DOCS / "files.md", 1),
        (DOCS / "models.md", 3),
        (DOCS / "ros2.md", 2),
        (DOCS / "twin.md", 3),
        (DOCS / "calibration.md", 1),
        (DOCS / "install.md", 1),
    ],
    ids=["README", "first-plan", "your-own-space", "files", "models", "ros2", "twin", "calibration", "install"],
)
def test_the_commands_say_what_the_page_says(page, count, tmp_path, monkeypatch, capfd):
    write_files_of(page, tmp_path)
    shutil.copy(ROOT / "examples" / "step_tank.step", tmp_path / "vessel.step")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hognose.report.report._FRAMES", 4)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("COLUMNS", "200")
    said = [re.split(r"^\$ (.*)\n", block, flags=re.MULTILINE)[1:] for block in blocks(page, "console")]
    commands = [pair for parts in said for pair in zip(parts[::2], parts[1::2], strict=True)]
    assert len(commands) == count
    for command, expected in commands:
        code, printed = outcome(command, capfd)
        pattern = re.escape(expected.strip()).replace("…", ".*")
        found = re.sub(r" +$", "", printed.strip(), flags=re.MULTILINE)
        assert re.fullmatch(pattern, found, re.DOTALL), found
        wrong = 2 if "hognose: --" in expected else 1
        assert code == wrong * ("hognose: " in expected or "NOT GOOD" in expected), command


def outcome(command, capfd):
    """The exit code and the output of a line of shell; Hognose runs in this process, which is much faster."""
    tokens = shlex.split(command)
    if tokens[0] != "hognose":
        done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr
    capfd.readouterr()
    with pytest.raises(SystemExit) as ended:
        main(tokens[1:])
    return ended.value.code, "".join(capfd.readouterr())


@pytest.fixture(scope="module")
def on_bases():
    """Plans of the examples of bases."""
    return {name: hognose.plan(hognose.load_task(name)) for name in ("slanted-vessel", "drum", "carrier")}


@pytest.mark.parametrize("name", ["slanted-vessel", "drum", "carrier"])
def test_an_example_of_a_base_makes_a_good_plan(on_bases, name):
    plan = on_bases[name]
    assert plan.good
    assert f"`hognose plan {name}`" in (DOCS / "base.md").read_text()
    report = plan.task.spec.report.times_s
    assert max(report) <= plan.time[-1]


def test_the_drum_of_the_example_needs_as_little_space_as_the_page_says(on_bases):
    plan = on_bases["drum"]
    robot = plan.robot
    assert -plan.body[..., 2].min() + robot.body_radii.max() == pytest.approx(0.5, abs=0.005)
    assert robot.length + robot.spec.base_length == pytest.approx(1.24, abs=0.006)


def test_the_carrier_of_the_example_takes_the_nose_farther_than_the_arm_is_long(on_bases):
    plan = on_bases["carrier"]
    assert np.linalg.norm(plan.joints[-1, -1] - plan.joints[0, -1]) > plan.robot.length


def test_the_vessel_of_the_example_is_what_its_script_writes():
    made = runpy.run_path(str(ROOT / "examples" / "make_slanted_vessel.py"))["vessel"]()
    kept = trimesh.load_mesh(ROOT / "examples" / "slanted_vessel.stl")
    np.testing.assert_allclose(made.bounds, kept.bounds, atol=1e-3)
    assert made.volume == pytest.approx(kept.volume, rel=1e-6)


def test_every_method_has_a_page_and_every_page_a_method():
    folder = DOCS / "methods"
    assert {page.stem for page in folder.glob("*.md")} - {"index"} == set(METHODS)
    listed = re.findall(r"^\| \[(\w+)\]\((\w+)\.md\)", (folder / "index.md").read_text(), re.MULTILINE)
    assert listed == [(name, name) for name in METHODS]


@pytest.mark.parametrize("name", list(METHODS))
def test_the_page_of_a_method_is_whole(name):
    text = (DOCS / "methods" / f"{name}.md").read_text()
    assert text.startswith(f"# {name}\n")
    assert re.search(r"^\$\$$.+?^\$\$$", text, re.MULTILINE | re.DOTALL), "an equation"
    sections = re.split(r"^## (.+)$", text, flags=re.MULTILINE)
    assert sections[1::2] == ["Source", "Cost", "Tolerance", "Weakness", "When to use"]
    assert all(len(section.split()) > 0 for section in sections[2::2])


@pytest.fixture(scope="module")
def of_the_page(tmp_path_factory):
    """The method of the page, from one file, whose kernels are compiled once."""
    file = tmp_path_factory.mktemp("method") / "secant.py"
    file.write_text(blocks(DOCS / "add-a-method.md", "python")[0])
    spec = importlib.util.spec_from_file_location("secant", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Secant


@pytest.fixture
def secant(of_the_page, monkeypatch):
    """That method, entered in the table."""
    monkeypatch.setitem(METHODS, of_the_page.name, of_the_page)
    return of_the_page


def test_the_added_method_agrees_with_exact_within_its_tolerance(secant):
    assert issubclass(secant, Follower)
    rng = np.random.default_rng(5)
    lengths = np.full(12, 0.091)
    feeds = np.concatenate([np.arange(0, 0.8, 0.0035), [0.1, 0.7, 0.1, 0.1], np.linspace(0.8, 0, 30)])
    for _ in range(10):
        points = np.zeros((5, 3))
        points[:, 2] = 0.25 * np.arange(5)
        points[1:, :2] = rng.uniform(-0.08, 0.08, (4, 2))
        path = hognose.Path.through(points, 3, (0, 0, 1)).with_run(lengths.sum())
        method = hognose.follower(path, lengths, "secant")
        assert method.tracks
        joints = method.run(feeds)
        links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
        assert np.abs(links - lengths).max() <= method.tolerance
        assert path.distance_to(joints).max() <= method.tolerance
        exact = hognose.follow(path, lengths, feeds)
        assert np.abs(joints - exact).max() <= lengths.size * method.tolerance
        assert 2 < method.evaluations / feeds.size / lengths.size < 6


def test_the_added_method_makes_good_plans(secant):
    for name in ("obstacle-array", "pipe-tank"):
        plan = hognose.plan(with_method(hognose.load_task(name), secant.name))
        assert plan.good


def test_what_the_page_says_of_followers_exists(secant):
    text = (DOCS / "add-a-method.md").read_text()
    follower = secant(hognose.Path.through([[0, 0, 0], [0, 0, 1]]), [0.1])
    named = set(re.findall(r"`self\.(\w+)`", text))
    assert {"path", "curve", "tracks", "_evaluations"} <= named
    for name in [*named, "keeps_to_path", "glides", "evaluations", "tolerance", "_curve", "_advance", "step", "run"]:
        assert hasattr(follower, name), name
        assert name.lstrip("_") in text, name
    arguments = list(inspect.signature(Follower).parameters)
    assert arguments == list(inspect.signature(secant).parameters)
    assert len(arguments) == 4, "the page says four"


@pytest.mark.parametrize("page", FILES)
def test_a_reference_page_lists_every_key_of_its_file(site, page):
    html = (site / "reference" / f"{page}.html").read_text()
    cells = re.findall(r'<tr class="row-(?:even|odd)"><td><p><code[^>]*><span class="pre">([^<]+)</span>', html)
    assert set(cells) == set(keys(FILES[page]))
    assert cells.count("time_s") <= 1  # what all kinds of obstacle have comes once


def test_the_page_of_checks_lists_every_one_as_it_is(site):
    html = (site / "checks.html").read_text()
    rows = re.findall(r'<tr class="row-(?:even|odd)">(.*?)</tr>', html, re.DOTALL)
    cells = [[re.sub("<[^>]+>", "", cell).strip() for cell in re.findall(r"<td>(.*?)</td>", row)] for row in rows]
    expected = [[each.key, each.name, each.unit, each.says] for each in ALL]
    assert [[unescape(text).replace("’", "'") for text in row] for row in cells if row] == expected


def keys(model):
    """Keys of a model and then of what it holds, depth first, as the page has them."""
    own = [field.alias or name for name, field in model.model_fields.items()]
    parts = [part for field in model.model_fields.values() for part in held(field.annotation)]
    return own + [key for part in parts for key in keys(part)]


def held(annotation):
    if inspect.isclass(annotation) and issubclass(annotation, FileModel):
        return [annotation]
    return [part for inner in getattr(annotation, "__args__", ()) for part in held(inner)]


def test_the_reference_says_types_units_defaults_and_what_is_required():
    robot, task = (REFERENCE["reference"](model) for model in FILES.values())
    for row in (
        "| `margin` | number, at least 0 | length | 5 mm |",
        "| `step` | number, above 0 | length | 3.5 mm |",
        "| `way_points` | list of 3 numbers, at most 500 | length |  |",
        '| `kind` | `"spline"`, `"bezier"`, `"bspline"` |  | `"spline"` |',
        "| `diameters` | 2 numbers, above 0 | length |  |",
        "| `normal` | 3 numbers |  | `[0.0, 0.0, 1.0]` |",
        '| `kind` | `"tank"` |  | **required** |',
    ):
        assert row in task, row
    for row in (
        "| `joint_acceleration_deg_s2` | number, at least 1e-09, at most 1e+09 | deg/s² | **required** |",
        "| `speed` | number, above 0 | length/s | **required** |",
        "| `bend_limit_deg` | number, above 0, at most 180; or 2 numbers, above 0, at most 180 | deg | **required** |",
        "| `link_mass` | number, at least 1e-09, at most 1000 | kg | **required** |",
    ):
        assert row in robot, row
    titles = [line for line in task.splitlines() if line.startswith("## ")]
    assert len(set(titles)) == len(titles)
    assert [title for title in titles if "obstacle.motion" in title] == ["## `[[obstacle.motion]]`, any kind"]
    assert "| `time_s` |" in task
    keep_out = task[task.index("## `[[path.keep_out]]`") : task.index("## `[motion]`")]
    assert "| `size` |" in keep_out
    assert "motion" not in keep_out


def test_a_key_without_words_and_words_without_a_key_are_errors():
    class New(FileModel):
        novelty: int

    with pytest.raises(KeyError, match="novelty is not described"):
        REFERENCE["reference"](New)
    assert REFERENCE["unknown_words"](list(FILES.values())) == []


def test_the_reference_has_every_public_name(site):
    html = (site / "reference" / "api.html").read_text()
    for name in hognose.__all__:
        assert f'id="hognose.{name}"' in html, name
    for room in ("following", "robot", "scene", "path", "planning", "steering", "files"):
        for name in importlib.import_module(f"hognose.{room}").__all__:
            assert f'id="hognose.{name}"' in html or f'id="hognose.{room}.{name}"' in html, f"{room}.{name}"


def test_docstrings_are_read_as_they_are_meant(site):
    html = (site / "reference" / "api.html").read_text()
    for name in ("joint_before", "joint_after", "cable_radii", "value", "limit", "starts", "ends"):
        assert f"<strong>{name}</strong>" in html, name
    text = re.sub(r"<[^>]+>", "", html)
    for words in (
        "Largest |α| and |β|",
        "a path ending in .toml",
        "every value of the robot: two robots with the same",
    ):
        assert words in text, words
