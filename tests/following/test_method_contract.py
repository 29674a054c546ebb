"""Methods of other packages that do not keep to the protocol: a sentence names method and package."""

import math
import re
import sys
from types import ModuleType

import numpy as np
import pytest
from extension_makers import Silent, described
from hypothesis import given
from hypothesis import strategies as st

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.extensions import added
from hognose.files import with_method
from hognose.following import METHODS, Follower
from hognose.following.exact import Exact
from hognose.following.follower import SOLVED

LENGTHS = [0.1, 0.08, 0.12]
PATH = hognose.Path.through([[0, 0, 0], [0, 0, 0.3], [0, 0.1, 0.6], [0.1, 0.1, 1.0]])
FEEDS = np.linspace(0.0, 0.4, 7)
NAMED = r"^method 'faulty' of my-package"


@pytest.fixture
def add(tmp_path, monkeypatch):
    """Add a method under the name `faulty` by an entry point of the package `my-package`."""
    module = ModuleType("added_method")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.syspath_prepend(tmp_path)
    described(tmp_path, "my-package", "1.0", {"hognose.methods": {"faulty": "added_method:Faulty"}})
    monkeypatch.setattr(METHODS, "_entries", dict(METHODS._entries))
    monkeypatch.setattr(METHODS, "_whole", False)
    added.cache_clear()

    def entered(base=Exact, **members):
        method = type("Faulty", (base,), {"name": "faulty", "__module__": module.__name__, **members})
        monkeypatch.setattr(module, "Faulty", method, raising=False)
        return method

    yield entered
    added.cache_clear()


def changed(change):
    """`_advance` that does as `exact` does, and then something else to what comes of it."""

    def advance(self, feeds, joints):
        outcome = Exact._advance(self, feeds, joints)
        return change(joints, outcome)

    return advance


def displaced(by):
    def change(joints, outcome):
        joints[:, 2, 2] += by
        return outcome

    return change


def lost(value, *at):
    def change(joints, outcome):
        joints[at] = value
        return outcome

    return change


def raising(error):
    def method(*given):
        raise error

    return method


def both_ways(said):
    """A run and a step end in the same sentence, but for the step's number."""
    follower = hognose.follower(PATH, LENGTHS, "faulty")
    for call in (lambda: follower.run(FEEDS), lambda: follower.step(0.0), lambda: follower.run([0.0])):
        with pytest.raises(InputError, match=NAMED + said) as caught:
            call()
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match=NAMED + said):
        hognose.follow(PATH, LENGTHS, FEEDS, "faulty")


def test_a_method_that_keeps_to_the_protocol_is_followed_as_it_is(add):
    add()
    assert (hognose.follow(PATH, LENGTHS, FEEDS, "faulty") == hognose.follow(PATH, LENGTHS, FEEDS)).all()
    follower = hognose.follower(PATH, LENGTHS, "faulty")
    assert (np.array([follower.step(feed) for feed in FEEDS]) == hognose.follow(PATH, LENGTHS, FEEDS)).all()
    assert follower.run([]).shape == (0, 4, 3)


@pytest.mark.parametrize("method", ["exact", "faulty"])
def test_a_link_that_finds_no_place_is_no_fault_of_the_method(add, method):
    add()
    with pytest.raises(InfeasibleError, match=r"^step 1, feed .*: link 2 \(80 mm\) cannot reach the path"):
        hognose.follow(PATH, LENGTHS, [0.0, PATH.length - 0.15], method)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ZeroDivisionError("by zero"), r" failed: ZeroDivisionError: by zero; "),
        (ValueError("one\n  two"), r" failed: ValueError: one two; "),
        (SystemExit(3), r" failed: SystemExit: 3; "),
        (Silent(), r" failed: Silent; "),
        (RuntimeError("x " * 1000), r" failed: RuntimeError: (x )+…; "),
        (InputError("s: expected less"), r": s: expected less$"),
    ],
)
def test_what_it_raises_is_said(add, error, said):
    add(_advance=raising(error))
    both_ways(said)
    for constructor in ("__init__", "_prepare", "_curve", "tolerance"):
        add(**{constructor: property(raising(error)) if constructor == "tolerance" else raising(error)})
        METHODS._whole = False
        METHODS._entries.pop("faulty", None)
        added.cache_clear()
        with pytest.raises(InputError, match=NAMED + said):
            hognose.follower(PATH, LENGTHS, "faulty")


def test_what_a_person_interrupts_is_no_fault(add):
    add(_advance=raising(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        hognose.follow(PATH, LENGTHS, FEEDS, "faulty")


@pytest.mark.parametrize(
    "outcome",
    [None, 0, (), (0,), (0, 0, 0), (-1, 0), (0, -1), (0, 3), (7, 0), ("a", 0), (0.0, 0.0), np.zeros((1, 4, 3))],
)
def test_what_it_returns_is_solved_or_a_step_and_a_link(add, outcome):
    add(_advance=changed(lambda joints, _: outcome))
    both_ways(
        r": its `_advance` returned .*; expected SOLVED, \(-1, -1\), or the step, 0 to \d, and the link, 0 to 2, "
    )


def test_joints_of_another_shape_are_said(add):
    def advance(self, feeds, joints):
        joints[:] = np.zeros((len(feeds), 3, 3))
        return SOLVED

    add(_advance=advance)
    both_ways(r" failed: ValueError: could not broadcast .* shape")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("joint", [0, 1, 3])
def test_a_joint_without_a_place_is_named(add, value, joint):
    add(_advance=changed(lost(value, -1, joint, 1)))
    both_ways(rf": step \d, feed \d+\.\d\d mm: it leaves joint {joint + 1} without a place, \[.*{value}.*\]; ")


def test_a_joint_that_it_does_not_fill_in_has_no_place(add):
    add(_advance=lambda self, feeds, joints: SOLVED)
    both_ways(r": step 0, feed 0\.00 mm: it leaves joint 1 without a place, \[nan, nan, nan\]; ")


def test_where_it_says_that_a_link_finds_no_place_the_joint_before_must_have_one(add):
    add(_advance=lambda self, feeds, joints: (0, 0))
    both_ways(r": step 0, feed 0\.00 mm: it leaves joint 1 without a place")


@pytest.mark.parametrize("by", [1e-9, 1e-3, 1e200])
def test_a_link_of_another_length_is_named(add, by):
    add(_advance=changed(displaced(by)))
    both_ways(r": step \d, feed .* mm: its joints make link [23] \S+ mm long; expected (80|120) mm to its tolerance")


@given(tolerance=st.floats(1e-9, 0.05), part=st.floats(-2.0, 2.0))
def test_links_may_be_off_by_the_tolerance_and_no_more(tolerance, part):
    """A last link that is shifted along itself changes by the whole shift."""

    def shift(joints, outcome):
        joints[:, 3] += part * tolerance * (joints[:, 3] - joints[:, 2]) / LENGTHS[2]
        return outcome

    method = type("Shifted", (Exact,), {"name": "shifted", "_advance": changed(shift), "tolerance": tolerance})
    if abs(part) <= 0.999:
        method(PATH, LENGTHS).run(FEEDS)
    elif abs(part) > 1.001:
        with pytest.raises(InputError, match=r"^method 'shifted' of the module \S+: step \d, .* make link 3"):
            method(PATH, LENGTHS).run(FEEDS)


@pytest.mark.parametrize("bad", [math.inf, math.nan, -1e-12, -math.inf, 0.08, None, "small", 1e-9j, True])
def test_a_tolerance_that_would_switch_checks_off_is_refused(add, bad):
    method = add(tolerance=property(lambda self: bad))
    got = re.escape(repr(bad))
    said = NAMED + rf": its tolerance: expected a length of at least 0 m and less than .* 0\.08 m, got {got}"
    with pytest.raises(InputError, match=said):
        hognose.follower(PATH, LENGTHS, "faulty")
    with pytest.raises(InputError, match=said):  # made without the table
        method(PATH, LENGTHS).run(FEEDS)


@pytest.mark.parametrize("each", ["step", "run"])
def test_what_the_base_class_checks_cannot_be_replaced(add, each):
    add(**{each: lambda self, feeds: np.zeros((1, 1))})
    with pytest.raises(InputError, match=rf"'faulty', which my-package adds, has a `{each}` of its own; .*`_advance`"):
        hognose.follow(PATH, LENGTHS, FEEDS, "faulty")


def test_a_method_without_what_it_must_define_is_named(add):
    add(base=Follower)
    with pytest.raises(InputError, match=NAMED + r" failed: TypeError: Can't instantiate abstract class Faulty"):
        hognose.follower(PATH, LENGTHS, "faulty")


def test_feeds_are_the_callers_own(add):
    def advance(self, feeds, joints):
        outcome = Exact._advance(self, feeds, joints)
        feeds[:] = np.nan
        return outcome

    add(_advance=advance)
    follower, feeds = hognose.follower(PATH, LENGTHS, "faulty"), FEEDS.copy()
    follower.run(feeds)
    np.testing.assert_array_equal(feeds, FEEDS)
    assert np.isfinite(follower.step(0.1)).all()


def test_a_plan_ends_in_the_sentence(add):
    add(_advance=changed(displaced(1e-3)))
    with pytest.raises(InputError, match=NAMED + r": step \d+, feed .* mm: its joints make link \d+ "):
        hognose.plan(with_method(hognose.load_task("pipe-tank"), "faulty"))


def test_hognoses_own_methods_are_believed(monkeypatch):
    """No time is spent on them: what they do wrong is a mistake in Hognose, and its traceback tells where."""
    assert all(method._own for name, method in METHODS.items())
    monkeypatch.setattr(Exact, "_advance", raising(ZeroDivisionError("by zero")))
    with pytest.raises(ZeroDivisionError):
        hognose.follow(PATH, LENGTHS, FEEDS)
