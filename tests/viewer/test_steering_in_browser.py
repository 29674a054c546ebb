"""The nose steered by hand, in a real browser: buttons, keys, mouse and gamepads."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browsing import WIDE, looked_at, running, wait
from playwright.sync_api import Page as Tab
from playwright.sync_api import expect
from workbench_makers import small

from hognose.viewer.model import edits
from hognose.viewer.page import Page
from hognose.viewer.server.stick import Deflection

PADS = """(listed) => {
  const buttons = Array.from({ length: 17 }, () => ({ value: 0 }));
  const id = "Pad 3 (STANDARD GAMEPAD Vendor: 045e Product: 028e)";
  window.pad = { id, connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons };
  navigator.getGamepads = () => [null, ...Array(listed).fill(window.pad)];
}"""


@pytest.fixture(scope="module")
def task():
    """Few things to be drawn."""
    return small()


@pytest.fixture(scope="module")
def page(task) -> Iterator[Page]:
    with running(task) as made:
        yield made


@pytest.fixture(scope="module")
def tab(chromium, page) -> Iterator[Tab]:
    """One window for all tests that do not close it."""
    with looked_at(chromium, page, WIDE) as found:
        yield found


@pytest.fixture
def steered(page, tab):
    """The arm, steered by hand from the entrance, as long as a test takes."""
    tab.get_by_role("tab", name="Steer").click()
    tab.get_by_text("steer the nose by hand").click()
    wait(lambda: page.steering.steered is not None)
    tab.locator("#hognose-stick").wait_for(state="visible")
    yield page.steering.steered
    if page.steering.steered is not None:
        tab.get_by_text("steer the nose by hand").click()
        wait(lambda: page.steering.steered is None)
        tab.locator("#hognose-stick").wait_for(state="hidden")


def test_a_browser_that_is_gone_has_let_go(chromium, task):
    with running(task) as page:
        with looked_at(chromium, page, WIDE) as other:
            other.get_by_role("tab", name="Steer").click()
            other.get_by_text("steer the nose by hand").click()
            other.locator("#hognose-stick").wait_for(state="visible")
            other.keyboard.down("r")
            wait(lambda: page.stick.deflection.on == 1)
        wait(lambda: page.stick.deflection == Deflection())


def test_the_nose_is_steered_by_steps_and_backs_out_exactly(page, tab, steered):
    for _ in range(4):
        tab.get_by_role("button", name="forward", exact=True).click()
    wait(lambda: steered.depth > 0.1)
    for _ in range(8):
        tab.get_by_role("button", name="back", exact=True).click()
    wait(lambda: steered.depth == 0.0)
    assert not steered.angles.any()
    expect(tab.locator("#hognose-stick")).to_contain_text("Stopped: ")
    tab.get_by_text("steer the nose by hand").click()
    wait(lambda: page.steering.steered is None)
    tab.locator("#hognose-stick").wait_for(state="hidden")


def test_held_keys_steer_and_letting_go_stops(page, tab, steered):
    for key in ("i", "l", "r"):
        tab.keyboard.down(key)
    wait(lambda: steered.depth > 0.1)
    for key in ("r", "i", "l"):
        tab.keyboard.up(key)
    wait(lambda: page.stick.deflection == Deflection())
    # Looking out of the nose, into +z with +y up, the right hand is towards -x.
    assert steered.tip[0] < -1e-3
    assert steered.tip[1] > 1e-3
    tab.keyboard.down("f")
    wait(lambda: steered.depth == 0.0)
    tab.keyboard.up("f")
    assert not steered.angles.any()


def test_the_pad_and_the_lever_are_pulled_with_the_mouse(page, tab, steered):
    assert steered is page.steering.steered
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
        wait(lambda pulled=pulled: pulled(page.stick.deflection))
        tab.mouse.up()
        wait(lambda: page.stick.deflection == Deflection())


def test_a_gamepad_steers_and_a_page_that_nobody_sees_has_let_go_of_it(page, tab, steered):
    tab.evaluate(PADS, 1)
    expect(tab.locator("#hognose-stick")).to_contain_text("gamepad: Pad 3")
    tab.evaluate("window.pad.axes[0] = -1, window.pad.axes[1] = 0.05, window.pad.buttons[7].value = 0.5")
    wait(lambda: page.stick.deflection.right < -0.99 and page.stick.deflection.on == 0.5)
    wait(lambda: steered.depth > 0.03)
    tab.evaluate("Object.defineProperty(document, 'hidden', { configurable: true, get: () => true })")
    wait(lambda: page.stick.deflection == Deflection())
    tab.evaluate("delete document.hidden")
    wait(lambda: page.stick.deflection.on == 0.5)
    tab.evaluate("window.pad.connected = false")
    wait(lambda: page.stick.deflection == Deflection())
    assert steered.tip[0] > 0


def test_a_gamepad_counts_once_however_often_it_is_listed_and_in_however_many_tabs(chromium, page, tab, steered):
    assert steered is page.steering.steered
    with looked_at(chromium, page, WIDE) as other:
        other.locator("#hognose-stick").wait_for(state="visible")
        for each in (tab, other):
            each.evaluate(PADS, 2)
            expect(each.locator("#hognose-stick")).to_contain_text("gamepad: Pad 3")
            each.evaluate("window.pad.buttons[7].value = 0.25, window.pad.axes[0] = 0.12 + 0.88 * 0.25")
        both = 2

        def heard() -> list[Deflection]:
            said = [hand.pushed.gamepads for hand in page.stick._hands.values()]
            return [push for pads in said for push in pads.values()]

        wait(lambda: len(heard()) == both and all(push.on == 0.25 for push in heard()))
        wait(lambda: page.stick.deflection.on > 0)
        for _ in range(20):
            pushed = page.stick.deflection  # of nobody, if the browsers are busy, but never of both
            assert (pushed.right, pushed.on) in ((0.25, 0.25), (0.0, 0.0))
        tab.evaluate("window.pad.connected = false")


def test_an_edit_while_steering_ends_it_and_says_so(page, tab, steered):
    tab.get_by_role("button", name="forward", exact=True).click()
    wait(lambda: steered.depth > 0.05)
    expect(tab.get_by_role("heading", name="Steered by hand")).to_be_visible()
    page.bench.edit(edits.set_margin(0.001))
    expect(tab.get_by_text("steer again from the entrance")).to_be_visible()
    tab.locator("#hognose-stick").wait_for(state="hidden")
    expect(tab.get_by_role("heading", name="GOOD")).to_be_visible()
