"""What people want of a run while it goes on: said at its terminal, or elsewhere."""

import threading

import numpy as np
import pytest
from drive_makers import Rig, boards

from hognose.drive.conductor import Conductor
from hognose.drive.settings import Phase
from hognose.drive.wishes import Want, Wish, Wishes
from hognose.errors import InfeasibleError

#: Nothing here depends on how a processor rounds.
pytestmark = pytest.mark.slow
FAR = 8.0


class Typist:
    """Somebody at a terminal who types one answer after another, each after some time."""

    def __init__(self, *answers):
        self.answers, self.asked, self._waited = list(answers), [], 0

    def ask(self, question):
        self.asked.append(question)
        self._waited = 0

    def answer(self):
        self._waited += 1
        if self._waited < 5:
            return None
        return self.answers.pop(0) if self.answers else ""


class Run:
    """A rig with a conductor; `at` has what happens at places along the plan, once each."""

    def __init__(self, terminal=None, at=()):
        self.rig, self.wishes = Rig(boards()).ready(), Wishes()
        self.conductor = Conductor(self.rig.executor, self.wishes, terminal)
        left = list(at)

        def look(cycle):
            self.conductor.notice()
            while left and cycle.set_point.place >= left[0][0]:
                left.pop(0)[1](self)

        self.rig.at_cycle.append(look)

    @property
    def runs(self):
        """Where legs began and were to end, in words."""
        return [words for kind, words, _ in self.rig.events if kind == "run"]

    def is_at(self, step):
        np.testing.assert_array_equal(self.rig.executor.axes.position, self.rig.counts[step])
        return self.rig.executor.place == step


def interrupt(run):
    run.conductor.interrupt()


def wants(*wanted):
    return lambda run: [run.wishes.put(want, "watch") for want in wanted]


def test_a_run_that_nobody_disturbs_comes_to_its_end():
    run = Run()
    assert run.conductor.go(FAR).trouble is None
    assert run.is_at(int(FAR))
    assert run.conductor.turned == ""


def test_ctrl_c_is_a_pause_after_which_it_goes_on():
    typist = Typist("g")
    run = Run(typist, at=[(3.0, interrupt)])
    assert run.conductor.go(FAR).trouble is None
    assert run.is_at(int(FAR))
    assert len(run.runs) == 2
    assert 3.0 < float(typist.asked[0].split()[1].rstrip(".")) < FAR
    # It held for longer than the drives' watchdogs while somebody thought about it: they were heard all the time.
    assert not run.rig.executor.axes.emergencies


def test_it_holds_for_as_long_as_somebody_thinks():
    typist = Typist()
    run = Run(typist, at=[(3.0, interrupt)])
    began, thought = run.rig.clock.now, []

    def answer():
        thought.append(began())
        return "e" if began() - thought[0] > 5.0 else None

    typist.answer = answer
    outcome = run.conductor.go(FAR)
    assert (outcome.trouble, run.rig.executor.phase) == (None, Phase.HELD)
    assert not run.rig.executor.axes.emergencies
    assert run.rig.executor.run(0.0).trouble is None
    assert run.is_at(0)


@pytest.mark.parametrize("goal", [3.0, 0.0])
def test_it_goes_step_by_step(goal):
    typist = Typist("s", "s", "s", "s")
    run = Run(typist)
    start = 0.0 if goal else 3.0
    run.rig.executor.run(start)
    assert run.conductor.go(goal, one_step=True).trouble is None
    assert run.is_at(int(goal))
    steps = range(1, 3) if goal else range(2, 0, -1)
    assert [question.split(".")[0] for question in typist.asked] == [f"step {step}" for step in steps]


def test_after_one_step_it_goes_on():
    typist = Typist("s", "g")
    run = Run(typist)
    assert run.conductor.go(FAR, one_step=True).trouble is None
    assert run.is_at(int(FAR))
    assert len(typist.asked) == 2


def test_it_retracts_from_wherever_it_is():
    run = Run(Typist("r"), at=[(4.4, interrupt)])
    outcome = run.conductor.go(FAR)
    assert (outcome.trouble, outcome.place) == (None, 0.0)
    assert run.is_at(0)
    assert run.conductor.turned.startswith("retracted from step ")


@pytest.mark.parametrize(("answer", "ends"), [("yes", 0.0), ("no", None)])
def test_what_is_wanted_elsewhere_is_confirmed_at_the_terminal(answer, ends):
    typist = Typist(answer, "e")
    run = Run(typist, at=[(4.0, wants(Want.RETRACT))])
    outcome = run.conductor.go(FAR)
    assert typist.asked[0].startswith("watch wants it to retract from step ")
    assert outcome.place == ends if ends is not None else 4.0 < outcome.place < FAR


def test_what_is_wanted_while_it_slows_down_comes_after_the_pause():
    run = Run(Typist("yes"), at=[(3.0, wants(Want.PAUSE, Want.GO_ON))])
    assert run.conductor.go(FAR).trouble is None
    assert run.is_at(int(FAR))
    assert len(run.runs) == 2


@pytest.mark.parametrize("wanted", [(Want.RETRACT,), (Want.PAUSE, Want.GO_ON), (Want.END,)])
def test_where_nobody_is_asked_nothing_that_is_wanted_elsewhere_moves_the_arm(wanted):
    run = Run(at=[(3.0, wants(*wanted))])
    outcome = run.conductor.go(FAR)
    assert outcome.trouble is None
    assert 3.0 < outcome.place < FAR
    assert len(run.runs) == 1


def test_where_nobody_is_asked_a_pause_is_the_end():
    run = Run(at=[(3.0, interrupt)])
    outcome = run.conductor.go(FAR)
    assert outcome.trouble is None
    assert 3.0 < outcome.place < FAR
    assert run.rig.executor.phase is Phase.HELD


@pytest.mark.parametrize("stop", [wants(Want.STOP), lambda run: (interrupt(run), interrupt(run))])
def test_all_axes_stop_at_once(stop):
    run = Run(Typist("g"), at=[(3.0, stop)])
    outcome = run.conductor.go(FAR)
    assert outcome.trouble is not None
    assert run.rig.executor.phase is Phase.STOPPED


def test_a_drive_that_fails_while_the_arm_holds_ends_the_wait():
    typist = Typist()
    run = Run(typist, at=[(3.0, interrupt)])
    drive, lost = run.rig.drive(6), []

    def answer():
        if not lost:
            lost.append(drive.lose_power())

    typist.answer = answer
    outcome = run.conductor.go(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.words.startswith("cable 7 (node 7): ")
    assert run.rig.executor.phase is Phase.STOPPED


def test_wishes_come_in_their_order():
    wishes = Wishes()
    wishes.put(Want.PAUSE, "a")
    wishes.put(Want.RETRACT, "b")
    for _ in range(1000):
        wishes.put(Want.PAUSE, "a")
    assert [wishes.take(), wishes.take(), wishes.take()] == [Wish(Want.PAUSE, "a"), Wish(Want.RETRACT, "b"), None]
    assert [want for want in Want if want.starts_motion] == [Want.GO_ON, Want.STEP, Want.RETRACT]


@pytest.mark.parametrize("place", [7.6, 7.9, 8.0])
def test_who_ends_it_at_its_goal_has_ended_it(place):
    run = Run(Typist("e"), at=[(place, interrupt)])
    run.conductor.go(FAR)
    assert run.conductor.turned.startswith("ended at step ")
    unasked = Run(at=[(place, interrupt)])
    unasked.conductor.go(FAR)
    assert unasked.conductor.turned.startswith("ended at step ")


@pytest.mark.parametrize(("said", "runs"), [("stop", 1), ("quit", 1), ("getout", 1), ("rest", 1), ("go on", 2)])
def test_only_whole_words_are_understood(said, runs):
    run = Run(Typist(said, "e"), at=[(3.0, interrupt)])
    run.conductor.go(FAR)
    assert len(run.runs) == runs


@pytest.mark.parametrize("want", [Want.STOP, Want.PAUSE])
def test_a_follower_stops_it_also_while_slack_is_taken_up(want):
    rig, wishes, put = Rig(boards()), Wishes(), []
    rig.drive(4).axis.actual = rig.drive(4).axis.demanded = float(rig.counts[0, 4]) + 2000.0
    conductor = Conductor(rig.executor, wishes)

    def look(cycle):
        if not put:
            put.append(wishes.put(want, "watch"))
        conductor.notice()

    rig.at_cycle.append(look)
    rig.executor.arm()
    rig.executor.hold()
    with pytest.raises(InfeasibleError, match="stop at once" if want is Want.STOP else "watch wants it to pause"):
        rig.executor.tension()
    assert rig.executor.phase is Phase.STOPPED
    assert abs(rig.drive(4).axis.actual - rig.counts[0, 4]) > 1000.0


def test_a_follower_that_was_declined_does_not_ask_again_and_again():
    typist = Typist("no", "e")
    run = Run(typist, at=[(3.0, wants(Want.RETRACT))])
    whole = typist.ask

    def ask(question):
        run.wishes.put(Want.RETRACT, "watch")
        whole(question)

    typist.ask = ask
    run.conductor.go(FAR)
    assert [question.split()[0] for question in typist.asked] == ["watch", "step"]


def test_a_wish_that_comes_by_a_signal_while_one_is_taken_does_not_wait_for_ever():
    wishes = Wishes()

    def both():
        with wishes._lock:
            wishes.put(Want.PAUSE, "terminal")

    thread = threading.Thread(target=both, daemon=True)
    thread.start()
    thread.join(30.0)
    assert not thread.is_alive()
