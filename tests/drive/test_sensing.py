"""What is sensed beside the drives: pictures are recorded, and a contact brings the arm to rest along its path."""

from typing import Any, cast

import numpy as np

from hognose.drive.motions import SetPoint
from hognose.drive.senses import Contact, Picture, Sensed, Sensing
from hognose.drive.settings import Phase
from hognose.drive.stream import Cycle


class Scripted:
    """Senses that feel what a test says, and an executor that is told to come to rest."""

    def __init__(self, place=10.0, phase=Phase.RUN):
        self.place, self.phase, self.refuses = place, phase, False
        self.refused, self.pictures, self._sensed, self.obstructed = [], [], Sensed(), ""
        self.axes = self.clock = self
        self._sensing = Sensing(cast(Any, self), cast(Any, self), cast(Any, self))

    def now(self):
        return 7.0

    def look(self, now):
        return self._sensed

    def image(self, time, jpeg):
        self.pictures.append((time, jpeg))

    def refuse_to_go_on(self, why):
        self.refused.append(why)
        self.refuses = True

    def feel(self, by, *forces):
        """Go by so many steps a cycle, and feel a force in each, or nothing; how often it was told to come to rest."""
        for force in forces:
            self.place += by
            contact = None if force is None else Contact("link 3 is pressed by board 2", force)
            self._sensed = Sensed((Picture(self.now(), b"jpeg"),), contact)
            self._sensing.cycle(Cycle(0.0, SetPoint(np.zeros(1, np.int64), self.place), 0.0))
        return len(self.refused)

    def stopped_by_8_newtons(self):
        assert self.feel(0.2, None, 0.9, 3.0) == 1
        assert self.refused == ["contact: link 3 is pressed by board 2 with 3.0 N"]
        assert self.feel(0.1, 6.0, 8.0) == 1  # while it comes to rest
        self.refuses = False  # the next motion
        return self


def test_a_contact_stops_it_and_pictures_are_recorded():
    scripted = Scripted().stopped_by_8_newtons()
    assert scripted.pictures == [(7.0, b"jpeg")] * 5


def test_the_way_back_is_open_also_where_the_contact_comes_and_goes():
    assert Scripted().stopped_by_8_newtons().feel(-0.2, 8.0, 5.0, 1.5, 7.0, None, 12.0, None, 16.0, 3.0, 0.5) == 1


def test_a_known_contact_that_doubles_stops_the_way_back():
    scripted = Scripted().stopped_by_8_newtons()
    assert scripted.feel(-0.2, 15.9) == 1
    assert scripted.feel(-0.2, 16.1) == 2


def test_a_contact_after_a_step_without_one_is_another_one():
    scripted = Scripted().stopped_by_8_newtons()
    assert scripted.feel(-0.25, 8.0, None, None, None) == 1
    assert scripted.feel(-0.25, None, 2.0) == 2


def test_it_is_not_let_further_in_until_it_went_a_step_without_the_contact():
    scripted = Scripted().stopped_by_8_newtons()
    only_back = "contact: link 3 is pressed by board 2 with 8.0 N; only the way back is open"
    assert scripted.obstructed == only_back
    scripted.feel(0.0, None, None)  # senses say nothing for a moment
    scripted.feel(-0.25, None, None, None)
    assert scripted.obstructed == only_back
    scripted.feel(-0.25, None)
    assert scripted.obstructed == ""


def test_at_step_0_it_may_go_in_again():
    scripted = Scripted(place=0.5)
    assert scripted.feel(0.1, 4.0) == 1
    assert scripted.obstructed
    scripted.feel(-0.6, None)
    assert (scripted.place, scripted.obstructed) == (0.0, "")


def test_on_the_way_in_a_known_contact_stops_it_again():
    assert Scripted().stopped_by_8_newtons().feel(0.2, 1.1) == 2


def test_what_it_touches_where_it_stands_is_known_and_stops_nothing():
    scripted = Scripted(phase=Phase.HELD)
    assert scripted.feel(0.0, 5.0) == 0  # such as after a stop by its tensions, which came first
    scripted.phase = Phase.RUN
    assert scripted.feel(-0.2, 9.0) == 0
    assert scripted.feel(0.2, 2.0) == 1


def test_a_contact_while_cables_are_tensioned_stops_that():
    assert Scripted(phase=Phase.TENSION).feel(0.0, 0.5, 1.5) == 1
    scripted = Scripted().stopped_by_8_newtons()
    scripted.phase = Phase.TENSION  # on the way back to the plan, wherever that is closest
    assert scripted.feel(0.3, 8.0) == 1
