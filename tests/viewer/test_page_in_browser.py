"""The page as a person uses it, in a real browser."""

from __future__ import annotations

import threading
from dataclasses import replace
from functools import partial
from http.server import BaseHTTPRequestHandler, HTTPServer

import numpy as np
import pytest
import viser
from browsing import LARGE, looked_at, on_screen, running, wait
from PIL import Image
from playwright.sync_api import expect
from workbench_makers import LONG

from hognose.files import bundled_tasks
from hognose.planning import tolerances
from hognose.report.animation import animate
from hognose.viewer import page as opening_page
from hognose.viewer.model import edits, replanner
from hognose.viewer.server.injected_script import SOCKET
from hognose.viewer.server.redirect import redirect_file

GOOD = "GOOD: 24.13 mm certified"


@pytest.mark.parametrize("source", ["detour", "step-tank", "find-a-way"])
def test_every_case_opens_and_says_its_verdict(chromium, source, monkeypatch):
    monkeypatch.setattr(opening_page, "FIRST_SEARCH", 600.0)  # shown as soon as found, however slow the machine
    with running(source, lit=source == "step-tank") as page, looked_at(chromium, page) as tab:
        verdict = tab.get_by_role("heading", name="GOOD:")
        expect(verdict).to_be_visible()
        expect(verdict).to_contain_text("mm certified")


def test_a_space_alone_opens(chromium):
    step = bundled_tasks()["step-tank"].with_name("step_tank.step")
    with running(str(step)) as page, looked_at(chromium, page) as tab:
        expect(tab.get_by_text("8 bodies, 8,524 triangles")).to_be_visible()
        assert len(page.stage.walls.parts) == 8
        assert list(page.stage.walls.shells) == ["step_tank: shell"]


def test_a_robot_alone_opens_in_free_space(chromium):
    with running("sjtu-25dof-99") as page, looked_at(chromium, page) as tab:
        expect(tab.get_by_text("nothing is closer than 50 mm")).to_be_visible()


def test_a_way_point_dragged_into_a_pipe_is_refused_and_undo_mends_it(chromium, tank):
    bench = tank.bench
    with looked_at(chromium, tank, LARGE) as tab:
        expect(tab.get_by_text(GOOD)).to_be_visible()
        before = np.array(bench.spec.path.way_points[1])
        size = np.linalg.norm(np.ptp(np.array(bench.spec.path.stops), axis=0))
        handle = before + np.array([0, 0.03 * size, 0])  # on the handle's y arrow
        wait(lambda: tank.plan is not None)
        x, y = on_screen(tank, tab, handle)
        tip = on_screen(tank, tab, before + np.array([0, -0.12, 0]))
        tab.mouse.move(x, y)
        tab.mouse.down()
        for part in np.linspace(0, 1, 12):
            tab.mouse.move(x + part * (tip[0] - x), y + part * (tip[1] - y))
        wait(lambda: bench.number > 0, "no edit came from the mouse")
        tab.mouse.up()
        wait(lambda: not bench.verdict.good)
        expect(tab.get_by_text("NOT GOOD")).to_be_visible()
        expect(tab.get_by_text("pipe 1").first).to_be_visible()
        tab.get_by_role("button", name="Show where").click()
        wait(lambda: tank.timeline.clock.shown == bench.verdict.step)
        assert not np.allclose(before, bench.spec.path.way_points[1], atol=0.01)
        while bench.can_undo:  # one drag, however often the hand was lost meanwhile
            number = bench.number
            tab.get_by_role("button", name="undo").click()
            wait(lambda number=number: bench.number > number)
        wait(lambda: bench.current is not None and bench.current.good)
        np.testing.assert_allclose(bench.spec.path.way_points[1], before, atol=1e-12)
        expect(tab.get_by_text(GOOD)).to_be_visible()


def test_the_budget_of_tolerances_is_in_a_folder(chromium):
    with running("tolerances") as page, looked_at(chromium, page, LARGE) as tab:
        tab.get_by_text("tolerances", exact=True).click()
        expect(tab.get_by_text("drawn arms")).to_be_visible()
        row = tab.get_by_role("row", name="12 calibration 0.1° (assumed)")
        expect(row).to_be_visible()
        assert page.plan is not None
        last = tolerances(page.plan).rows[-1]
        expect(row.get_by_role("cell").last).to_have_text(last[-1])
        tab.add_style_tag(content=".hognose-links { letter-spacing: 0.08em }")  # as other fonts are wider
        panel = tab.locator(".hognose-links .wide")
        assert panel.evaluate("(each) => each.scrollWidth <= each.clientWidth"), "the table is cut off"


def test_while_an_edit_is_planned_the_verdict_before_is_not_the_verdict(tank, tab, monkeypatch):
    go, plan = threading.Event(), replanner.judged
    monkeypatch.setattr(replanner, "judged", lambda question: go.wait(LONG) and plan(question))
    try:
        expect(tab.get_by_role("heading", name=GOOD)).to_be_visible()
        margin = tab.get_by_role("textbox", name="margin, mm")
        margin.fill("40")
        margin.press("Enter")
        expect(tab.get_by_role("heading", name="planning …")).to_be_visible()
        expect(tab.get_by_role("heading", name="GOOD")).to_have_count(0)
        expect(tab.get_by_text(f"before: {GOOD}")).to_be_visible()
        expect(tab.get_by_text("no motion of the current task")).to_be_visible()
        tab.get_by_role("tab", name="Share").click()
        tab.get_by_role("button", name="Report (HTML)").click()
        expect(tab.get_by_text("the task is still being planned")).to_be_visible()
    finally:
        go.set()
    expect(tab.get_by_role("heading", name="NOT GOOD")).to_be_visible()
    expect(tab.get_by_text("of 45.4 s")).to_be_visible()


def test_the_time_line_plays_steps_and_scrubs(still, watched):
    still.timeline.clock = replace(still.timeline.clock.to(0), speed=10.0)
    watched.get_by_role("button", name="play / stop").click()
    wait(lambda: still.timeline.clock.row > 20)
    watched.get_by_role("button", name="play / stop").click()
    wait(lambda: not still.timeline.clock.playing)
    still.timeline.go(100)
    watched.get_by_role("button", name=">", exact=True).click()
    wait(lambda: still.timeline.clock.shown == 101)
    watched.get_by_role("button", name=">|").click()
    wait(lambda: still.timeline.clock.at_end)
    expect(watched.get_by_text("45.4 of 45.4 s")).to_be_visible()
    watched.get_by_role("button", name="out again").click()
    wait(lambda: still.timeline.clock.outwards)
    watched.get_by_role("button", name="play / stop").click()
    wait(lambda: still.timeline.clock.row < 200)
    watched.get_by_role("button", name="|<").click()
    wait(lambda: still.timeline.clock.shown == 0)


def test_a_route_is_found_from_the_page(tank, tab):
    number = tank.bench.number
    tab.get_by_role("textbox", name="seconds").fill("600")
    tab.get_by_role("textbox", name="seconds").press("Enter")
    tab.get_by_role("button", name="Find a route").click()
    wait(lambda: tank.bench.number > number, "no route was found")
    tab.get_by_role("button", name="Stop the search").click()
    wait(lambda: not tank.bench.searching)
    tank.bench.settle(LONG)
    assert tank.bench.current.good
    tab.get_by_role("button", name="undo").click()
    wait(lambda: len(tank.bench.spec.path.way_points) == 3)


#: By button, the ending of what it makes, how that begins, and how long it is at least.
TAKEN = {
    "Picture (PNG)": ("png", b"\x89PNG", 5_000),
    "Video (MP4)": ("mp4", b"\0\0\0", 5_000),
    "Report (HTML)": ("html", b"<!doctype html", 100_000),
    "Recording (HTML)": ("html", b"<!doctype html", 10_000),
}


def test_what_is_seen_can_be_taken_along(chromium, watched, tmp_path, monkeypatch):
    # Of each motion few pictures are drawn: the tests of the report draw more.
    monkeypatch.setattr("hognose.report.report._FRAMES", 4)
    monkeypatch.setattr("hognose.report.animation.animate", partial(animate, frames=15))
    monkeypatch.setattr("hognose.viewer.sharing.MOST_FRAMES", 15)
    watched.get_by_role("tab", name="Share").click()
    watched.get_by_role("combobox", name="size of pictures").click()
    watched.get_by_role("option", name="640 × 360").click()
    for button, (ending, begins, smallest) in TAKEN.items():
        with watched.expect_download() as download:
            watched.get_by_role("button", name=button).click()
        file = tmp_path / download.value.suggested_filename
        download.value.save_as(file)
        data = file.read_bytes()
        assert file.name.endswith(ending)
        assert data.lower().startswith(begins.lower())
        assert smallest < len(data) < 20_000_000
    with Image.open(tmp_path / "pipe-tank.png") as picture:
        assert picture.size == (640, 360)
        assert len(set(picture.convert("RGB").get_flattened_data())) > 100
    opens_without_a_server(chromium, tmp_path / "pipe-tank-recording.html")


def opens_without_a_server(chromium, file):
    context = chromium.new_context(offline=True)
    context.set_default_timeout(1e3 * LONG)
    errors: list[str] = []
    try:
        alone = context.new_page()
        alone.on("pageerror", lambda error: errors.append(str(error)))
        alone.goto(file.as_uri())
        alone.locator("canvas").first.wait_for()
    finally:
        context.close()
    assert errors == []


def test_without_the_token_a_browser_is_refused(chromium, still):
    tab = chromium.new_page()
    try:
        answer = tab.goto(f"http://127.0.0.1:{still.address.port}/")
        assert answer is not None
        assert answer.status == 403
        expect(tab.get_by_text("Copy the whole address that the command printed")).to_be_visible()
    finally:
        tab.close()


@pytest.mark.parametrize("script", [True, False])
def test_the_file_that_the_browser_is_given_leads_to_the_page_and_the_token_is_left_nowhere(chromium, still, script):
    context = chromium.new_context(java_script_enabled=script)
    context.set_default_timeout(1e3 * LONG)
    try:
        tab = context.new_page()
        asked: list[str] = []
        tab.on("response", lambda response: asked.append(f"{response.status} {response.url}"))
        before = len(still.server.get_clients())
        with redirect_file(still.address.url) as file:
            tab.goto(file.as_uri())
            home = f"http://127.0.0.1:{still.address.port}/"
            tab.wait_for_url(home)
            wait(lambda: f"200 {home}" in asked)
            if script:
                wait(lambda: len(still.server.get_clients()) > before, "the browser did not come in")
                assert tab.evaluate("navigation.entries().map((entry) => entry.url)") == [home]
                assert tab.evaluate("document.referrer + document.cookie") == ""
    finally:
        context.close()


def test_a_page_of_others_gets_nothing_even_in_a_browser_that_has_the_cookie(chromium, still):
    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<title>elsewhere</title>")

        def log_message(self, format, *args):
            del format, args

    server = HTTPServer(("127.0.0.1", 0), Foreign)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    context = chromium.new_context()
    context.set_default_timeout(1e3 * LONG)
    try:
        ours, other = context.new_page(), context.new_page()
        ours.goto(still.address.url)
        ours.wait_for_url(f"http://127.0.0.1:{still.address.port}/")
        other.goto(f"http://127.0.0.1:{server.server_port}/")
        opened = """([port, path, protocols]) => new Promise((done) => {
          const socket = new WebSocket(`ws://127.0.0.1:${port}${path}`, protocols);
          socket.onopen = () => done("open");
          socket.onerror = () => done("refused");
        })"""
        for path, protocols in (("/", [f"viser-v{viser.__version__}"]), (SOCKET, [])):
            assert ours.evaluate(opened, [still.address.port, path, protocols]) == "open"
            assert other.evaluate(opened, [still.address.port, path, protocols]) == "refused"
        read = "(address) => fetch(address, { credentials: 'include' }).then((r) => r.status, () => 'refused')"
        address = f"http://127.0.0.1:{still.address.port}/"
        assert ours.evaluate(read, address) == 200
        assert other.evaluate(read, address) == "refused"
    finally:
        context.close()
        server.shutdown()
        server.server_close()


def test_two_browsers_see_and_edit_the_same(chromium, tank, tab):
    with looked_at(chromium, tank) as other:
        for each in (tab, other):
            expect(each.get_by_text(GOOD)).to_be_visible()
        margin = tab.get_by_role("textbox", name="margin, mm")
        margin.fill("40")
        margin.press("Enter")
        for each in (tab, other):
            expect(each.get_by_text("NOT GOOD")).to_be_visible()
            expect(each.get_by_role("textbox", name="margin, mm")).to_have_value("40")
        other.get_by_role("button", name="undo").click()
        for each in (tab, other):
            expect(each.get_by_text(GOOD)).to_be_visible()
        assert tank.bench.spec.margin == 0.005


def test_edits_outlive_a_reload(tank, tab):
    step = tab.get_by_role("textbox", name="feed step, mm")
    step.fill("7")
    step.press("Enter")
    wait(lambda: tank.bench.spec.motion.step == 0.007)
    tab.reload()
    expect(tab.get_by_role("textbox", name="feed step, mm")).to_have_value("7")
    tab.get_by_role("button", name="undo").click()
    wait(lambda: tank.bench.spec.motion.step == 0.0035)


def test_a_target_that_is_too_far_shows_the_space_and_the_reason(tank, tab):
    tank.bench.edit(edits.move_way_point(2, (0.0, 0.0, 5.0)))
    expect(tab.get_by_text("the target is too far").first).to_be_visible()
    expect(tab.get_by_text("it does not belong to this task")).to_be_visible()
    tank.bench.undo()
    expect(tab.get_by_text(GOOD)).to_be_visible()


def test_names_that_no_file_here_can_have_are_answered(tank, tab):
    field = tab.locator("input[value='pipe-tank.toml']")  # its label is not tied to it
    for name, answer in (("../out.toml", "files are written within"), ("x" * 300, "too long for a file name")):
        field.fill(name)
        wait(lambda name=name: tank.editing._file.value == name)
        field = tab.locator(f"input[value='{name}']")
        tab.get_by_role("button", name="task", exact=True).click()
        expect(tab.get_by_text(answer)).to_be_visible()
    assert tank.bench.source is None
