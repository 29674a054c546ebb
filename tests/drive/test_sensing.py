"""What is sensed beside the drives: pictures are recorded, and a contact brings the arm to rest along its path."""

from typing import Any, cast

from hognose.drive.senses import Contact, Picture, Sensed, Sensing


class Scripted:
    """Senses that feel what a test says, and an executor that is told to come to rest."""

    refuses = False

    def __init__(self):
        self.force, self.refused, self.pictures = 0.0, [], []
        self.axes = self.clock = self

    def now(self):
        return 7.0

    def look(self, now):
        return Sensed((Picture(now, b"jpeg"),), Contact("link 3 is pressed by board 2", self.force))

    def tip(self):
        return None

    def image(self, time, jpeg):
        self.pictures.append((time, jpeg))

    def refuse_to_go_on(self, why):
        self.refused.append(why)
        self.refuses = True


def test_a_contact_stops_it_and_the_way_out_is_open():
    scripted = Scripted()
    sensing = Sensing(scripted, cast(Any, scripted), cast(Any, scripted))

    def feel(*forces):
        for scripted.force in forces:
            sensing.cycle(cast(Any, None))
        return len(scripted.refused)

    assert feel(0.2, 0.9) == 0
    assert feel(3.0) == 1
    assert scripted.refused == ["contact: link 3 is pressed by board 2 with 3.0 N"]
    assert feel(9.0, 8.0) == 1  # while it comes to rest
    scripted.refuses = False  # the next motion: back
    assert feel(8.0, 9.0, 5.0, 2.0, 0.5) == 1
    assert feel(4.0) == 2  # it was free meanwhile
    assert scripted.pictures[0] == (7.0, b"jpeg")
