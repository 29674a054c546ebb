"""The report's section on mechanics, and the line of the viewer's verdict."""

import re

import pytest

import hognose
from hognose.planning.loads import in_a_line, loads
from hognose.report.report import write_report
from hognose.robot import Robot


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


@pytest.fixture(scope="module")
def bare(plan):
    robot = Robot.from_spec(plan.robot.spec.model_copy(update={"cables": None, "assumed": ()}))
    return hognose.plan(hognose.Task(plan.task.spec, robot))


def text_of(plan, folder):
    write_report(plan, folder / "page.html", animation=False)
    return (folder / "page.html").read_text()


def test_the_page_says_what_cables_pull_and_on_what_that_rests(plan, tmp_path):
    page = text_of(plan, tmp_path)
    start = page.index("<h2>Will the arm hold it?</h2>")
    section = page[start : page.index("<h2>Checks</h2>")]
    found = loads(plan)
    for name, *cells in found.rows:
        row = re.search(rf'<th scope="row">{re.escape(name)}</th>(.*)</tr>', section)
        assert row is not None, name
        assert re.findall(r">([^<]*)</td>", row[1]) == cells
    for name, value, mark in found.given:
        assert f'<th scope="row">{name}</th><td>{value}</td><td>{mark}</td>' in section
    assert "data:image/svg+xml;base64," in section
    assert ("pretension", "40 N", "assumed") in found.given
    assert ("masses of links", "62 g", "") in found.given
    assert ("gravity", "0, -9.80665, 0 m/s²", "") in found.given


def test_a_plan_without_mechanics_has_no_such_section_and_says_why(bare, tmp_path):
    page = text_of(bare, tmp_path)
    assert "Will the arm hold it?" not in page
    assert "Not judged: largest tension." in page
    assert "mechanics are not known: the robot file has no table [cables]" in page


def test_the_line_has_the_figures_of_the_checks(plan, bare):
    least, most, factor = (plan.check(key).value for key in ("slack", "peak_tension", "buckling"))
    assert in_a_line(plan) == f"tensions {least:.3g} to {most:.3g} N, load factor of buckling {factor:.3g}"
    assert in_a_line(bare) == ""


def test_only_what_is_assumed_is_marked(plan):
    spec = plan.robot.spec.model_copy(update={"assumed": ("cables.friction", "section.link_mass")})
    robot = Robot.from_spec(spec)
    marked = loads(hognose.plan(hognose.Task(plan.task.spec, robot))).given
    assert [name for name, _, mark in marked if mark] == ["friction in the holes", "masses of links"]
