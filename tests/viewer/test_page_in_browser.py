"""The page as a person uses it, in a real browser."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, HTTPServer

import numpy as np
import pytest
import viser
from browsing import looked_at, on_screen, running, wait
from PIL import Image
from playwright.sync_api import expect

from benchmarks.chromium import browser
from hognose.files import bundled_tasks
from hognose.viewer import edits
from hognose.viewer.addition import SOCKET
from hognose.viewer.stick import Deflection


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def tank():
    with running("pipe-tank") as page:
        assert page.bench is not None
        page.bench.settle(60)
        yield page


@pytest.mark.parametrize("source", ["obstacle-array", "detour", "step-tank", "find-a-way"])
def test_every_case_opens_and_says_its_verdict(chromium, source):
    with running(source) as page, looked_at(chromium, page) as tab:
        verdict = tab.get_by_role("heading", name="GOOD:")
        expect(verdict).to_be_visible(timeout=60_000)
        expect(verdict).to_contain_text("mm certified")


def test_a_space_alone_opens(chromium):
    step = bundled_tasks()["step-tank"].with_name("step_tank.step")
    with running(str(step)) as page, looked_at(chromium, page) as tab:
        expect(tab.get_by_text("8 bodies, 8,524 triangles")).to_be_visible(timeout=60_000)
        assert len(page.stage.walls.parts) == 8
        assert list(page.stage.walls.shells) == ["step_tank: shell"]


def test_a_robot_alone_opens_in_free_space(chromium):
    with running("zju-24cable") as page, looked_at(chromium, page) as tab:
        expect(tab.get_by_text("nothing is closer than 50 mm")).to_be_visible(timeout=60_000)


def test_a_way_point_dragged_into_a_pipe_is_refused_and_undo_mends_it(chromium, tank):
    bench = tank.bench
    with looked_at(chromium, tank) as tab:
        expect(tab.get_by_text("GOOD: 24.13 mm certified")).to_be_visible(timeout=60_000)
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
            tab.wait_for_timeout(150)
        tab.mouse.up()
        wait(lambda: bench.number > 0, "no edit came from the mouse")
        wait(lambda: not bench.verdict.good)
        expect(tab.get_by_text("NOT GOOD")).to_be_visible(timeout=60_000)
        expect(tab.get_by_text("pipe 1").first).to_be_visible()
        tab.get_by_role("button", name="Show where").click()
        wait(lambda: tank.timeline.clock.shown == bench.verdict.step)
        assert not np.allclose(before, bench.spec.path.way_points[1], atol=0.01)
        tab.get_by_role("button", name="undo").click()
        wait(lambda: bench.verdict.good and bench.verdict.number == bench.number)
        np.testing.assert_allclose(bench.spec.path.way_points[1], before, atol=1e-12)
        expect(tab.get_by_text("GOOD: 24.13 mm certified")).to_be_visible(timeout=60_000)


def test_the_time_line_plays_steps_and_scrubs(chromium, tank):
    with looked_at(chromium, tank) as tab:
        tank.timeline.clock = replace(tank.timeline.clock.to(0), speed=10.0)
        tab.get_by_role("button", name="play / stop").click()
        wait(lambda: tank.timeline.clock.row > 20)
        tab.get_by_role("button", name="play / stop").click()
        wait(lambda: not tank.timeline.clock.playing)
        row = tank.timeline.clock.shown
        tab.get_by_role("button", name=">", exact=True).click()
        wait(lambda: tank.timeline.clock.shown == row + 1)
        tab.get_by_role("button", name=">|").click()
        wait(lambda: tank.timeline.clock.at_end)
        expect(tab.get_by_text("45.4 of 45.4 s")).to_be_visible(timeout=60_000)
        tab.get_by_role("button", name="out again").click()
        tab.get_by_role("button", name="play / stop").click()
        wait(lambda: tank.timeline.clock.row < 200)
        tab.get_by_role("button", name="|<").click()
        wait(lambda: tank.timeline.clock.shown == 0)


@contextmanager
def steering(tank, tab):
    """The nose steered by hand, until the end."""
    tab.get_by_role("tab", name="Steer").click()
    tab.get_by_text("steer the nose by hand").click()
    wait(lambda: tank.steering.steered is not None)
    tab.locator("#hognose-stick").wait_for(state="visible")
    yield tank.steering.steered
    tab.get_by_text("steer the nose by hand").click()
    wait(lambda: tank.steering.steered is None)
    tab.locator("#hognose-stick").wait_for(state="hidden")


def test_the_nose_is_steered_by_steps_and_backs_out_exactly(chromium, tank):
    with looked_at(chromium, tank) as tab, steering(tank, tab) as steered:
        for _ in range(4):
            tab.get_by_role("button", name="on", exact=True).click()
        wait(lambda: steered.depth > 0.035)
        deep = steered.depth
        for _ in range(8):
            tab.get_by_role("button", name="back", exact=True).click()
        wait(lambda: steered.depth == 0.0)
        assert deep > 0.035
        assert not steered.angles.any()
        expect(tab.locator("#hognose-stick")).to_contain_text("Held: ")


def test_held_keys_steer_and_letting_go_stops(chromium, tank):
    with looked_at(chromium, tank) as tab, steering(tank, tab) as steered:
        for key in ("r", "i", "l"):
            tab.keyboard.down(key)
        wait(lambda: steered.depth > 0.1)
        for key in ("r", "i", "l"):
            tab.keyboard.up(key)
        wait(lambda: tank.stick.deflection == Deflection())
        tip, depth = steered.tip, steered.depth
        # Looking out of the nose, into +z with +y up, the right hand is towards -x.
        assert tip[0] < -1e-3
        assert tip[1] > 1e-3
        tab.wait_for_timeout(500)
        assert steered.depth == depth
        tab.keyboard.down("f")
        wait(lambda: steered.depth == 0.0)
        tab.keyboard.up("f")
        assert not steered.angles.any()


def test_the_pad_and_the_lever_are_pulled_with_the_mouse(chromium, tank):
    with looked_at(chromium, tank) as tab, steering(tank, tab):
        for well, inside, pulled in (
            (".well:not(.lever)", (0.9, 0.5), lambda push: push.right > 0.7 and abs(push.up) < 0.1),
            (".lever", (0.5, 0.05), lambda push: push.on > 0.9),
        ):
            box = tab.locator(f"#hognose-stick {well}").bounding_box()
            assert box is not None
            x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
            tab.mouse.move(x, y)
            tab.mouse.down()
            tab.mouse.move(box["x"] + inside[0] * box["width"], box["y"] + inside[1] * box["height"])
            wait(lambda pulled=pulled: pulled(tank.stick.deflection))
            tab.mouse.up()
            wait(lambda: tank.stick.deflection == Deflection())


def test_a_gamepad_steers(chromium, tank):
    with looked_at(chromium, tank) as tab, steering(tank, tab) as steered:
        tab.evaluate(
            """() => {
              const buttons = Array.from({ length: 17 }, () => ({ value: 0 }));
              window.pad = { id: "Pad 3", connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons };
              navigator.getGamepads = () => [null, window.pad];
            }"""
        )
        expect(tab.locator("#hognose-stick")).to_contain_text("gamepad: Pad 3")
        tab.evaluate("window.pad.axes[0] = -1, window.pad.axes[1] = 0.05, window.pad.buttons[7].value = 0.5")
        wait(lambda: tank.stick.deflection.right < -0.99 and tank.stick.deflection.on == 0.5)
        wait(lambda: steered.depth > 0.03)
        tab.evaluate("window.pad.connected = false")
        wait(lambda: tank.stick.deflection == Deflection())
        assert steered.tip[0] > 0


def test_a_browser_that_is_gone_has_let_go(chromium, tank):
    with looked_at(chromium, tank) as tab:
        with looked_at(chromium, tank) as other:
            other.get_by_role("tab", name="Steer").click()
            other.get_by_text("steer the nose by hand").click()
            other.locator("#hognose-stick").wait_for(state="visible")
            other.keyboard.down("r")
            wait(lambda: tank.stick.deflection.on == 1)
        wait(lambda: tank.stick.deflection == Deflection())
        tab.get_by_role("tab", name="Steer").click()
        tab.get_by_text("steer the nose by hand").click()
        wait(lambda: tank.steering.steered is None)


def test_a_route_is_found_from_the_page(chromium, tank):
    with looked_at(chromium, tank) as tab:
        number = tank.bench.number
        tab.get_by_role("tab", name="Edit").click()
        tab.get_by_role("button", name="Find a route").click()
        wait(lambda: tank.bench.number > number, "no route was found")
        tab.get_by_role("button", name="Stop the search").click()
        wait(lambda: not tank.bench.searching)
        tank.bench.settle(60)
        assert tank.bench.verdict.good
        tab.get_by_role("button", name="undo").click()
        wait(lambda: len(tank.bench.spec.path.way_points) == 3)


def test_a_recording_opens_without_a_server(chromium, tank, tmp_path):
    with looked_at(chromium, tank) as tab:
        tab.get_by_role("tab", name="Share").click()
        with tab.expect_download(timeout=60_000) as download:
            tab.get_by_role("button", name="Recording (HTML)").click()
        file = tmp_path / "recording.html"
        download.value.save_as(file)
    assert 10_000 < file.stat().st_size < 20_000_000
    context = chromium.new_context(offline=True)
    tab = context.new_page()
    errors: list[str] = []
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.goto(file.as_uri())
    tab.locator("canvas").first.wait_for(timeout=60_000)
    context.close()
    assert errors == []


@pytest.mark.parametrize(
    ("button", "name", "begins", "smallest"),
    [
        ("Picture (PNG)", "png", b"\x89PNG", 5_000),
        ("Video (MP4)", "mp4", b"\0\0\0", 20_000),
        ("Report (HTML)", "html", b"<!doctype html", 100_000),
    ],
)
def test_what_is_seen_can_be_taken_along(chromium, tank, tmp_path, button, name, begins, smallest):
    with looked_at(chromium, tank) as tab:
        tab.get_by_role("tab", name="Share").click()
        tab.get_by_role("combobox", name="size of pictures").click()
        tab.get_by_role("option", name="640 × 360").click()
        with tab.expect_download(timeout=120_000) as download:
            tab.get_by_role("button", name=button).click()
        file = tmp_path / download.value.suggested_filename
        download.value.save_as(file)
    data = file.read_bytes()
    assert file.name.endswith(name)
    assert data.lower().startswith(begins.lower())
    assert len(data) > smallest
    if button.startswith("Picture"):
        with Image.open(file) as picture:
            assert picture.size == (640, 360)
            assert len(set(picture.convert("RGB").get_flattened_data())) > 100


def test_without_the_token_a_browser_is_refused(chromium, tank):
    tab = chromium.new_page()
    answer = tab.goto(f"http://127.0.0.1:{tank.address.port}/")
    assert answer is not None
    assert answer.status == 403
    expect(tab.get_by_text("Copy the whole address that the command printed")).to_be_visible()
    tab.close()


def test_a_page_of_others_gets_nothing_even_in_a_browser_that_has_the_cookie(chromium, tank):
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
    ours, other = context.new_page(), context.new_page()
    ours.goto(tank.address.url)
    other.goto(f"http://127.0.0.1:{server.server_port}/")
    opened = """([port, path, protocols]) => new Promise((done) => {
      const socket = new WebSocket(`ws://127.0.0.1:${port}${path}`, protocols);
      socket.onopen = () => done("open");
      socket.onerror = () => done("refused");
    })"""
    for path, protocols in (("/", [f"viser-v{viser.__version__}"]), (SOCKET, [])):
        assert ours.evaluate(opened, [tank.address.port, path, protocols]) == "open"
        assert other.evaluate(opened, [tank.address.port, path, protocols]) == "refused"
    read = "(address) => fetch(address, { credentials: 'include' }).then((r) => r.status, () => 'refused')"
    address = f"http://127.0.0.1:{tank.address.port}/"
    assert ours.evaluate(read, address) == 200
    assert other.evaluate(read, address) == "refused"
    context.close()
    server.shutdown()
    server.server_close()


def test_two_browsers_see_and_edit_the_same(chromium, tank):
    bench = tank.bench
    with looked_at(chromium, tank) as one, looked_at(chromium, tank) as two:
        for tab in (one, two):
            expect(tab.get_by_text("GOOD: 24.13 mm certified")).to_be_visible(timeout=60_000)
        margin = one.get_by_role("textbox", name="margin, mm")
        margin.fill("40")
        margin.press("Enter")
        for tab in (one, two):
            expect(tab.get_by_text("NOT GOOD")).to_be_visible(timeout=60_000)
            expect(tab.get_by_role("textbox", name="margin, mm")).to_have_value("40")
        two.get_by_role("button", name="undo").click()
        for tab in (one, two):
            expect(tab.get_by_text("GOOD: 24.13 mm certified")).to_be_visible(timeout=60_000)
        assert bench.spec.margin == 0.005


def test_edits_outlive_a_reload(chromium, tank):
    with looked_at(chromium, tank) as tab:
        step = tab.get_by_role("textbox", name="feed step, mm")
        step.fill("7")
        step.press("Enter")
        wait(lambda: tank.bench.spec.motion.step == 0.007)
        tab.reload()
        expect(tab.get_by_role("textbox", name="feed step, mm")).to_have_value("7", timeout=60_000)
        tab.get_by_role("button", name="undo").click()
        wait(lambda: tank.bench.spec.motion.step == 0.0035)


def test_a_target_that_is_too_far_shows_the_space_and_the_reason(chromium, tank):
    far = (0.0, 0.0, 5.0)
    with looked_at(chromium, tank) as tab:
        tank.bench.edit(edits.move_way_point(2, far))
        expect(tab.get_by_text("the target is too far").first).to_be_visible(timeout=60_000)
        expect(tab.get_by_text("the arm shows the last motion that could be made")).to_be_visible()
        tank.bench.undo()
        expect(tab.get_by_text("GOOD: 24.13 mm certified")).to_be_visible(timeout=60_000)
