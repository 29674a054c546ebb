"""Drives that do not know where they are never move, and are told where they are without moving, all or none."""

import dataclasses
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from drive_makers import REALISTIC, Rig, boards, network_of

from hognose.calibration import Accuracy, Calibration, Prior
from hognose.calibration.fit import Fit
from hognose.drive.cia402 import State
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.faults import Fault
from hognose.drive.executor import Phase
from hognose.drive.homing import Homing, zeros_of
from hognose.drive.local_bus import LocalBus
from hognose.drive.network import Network, load_network
from hognose.drive.recorder import Recorder
from hognose.errors import InfeasibleError, InputError

pytestmark = pytest.mark.slow


class New(Rig):
    """Drives whose supply has just come on."""

    def __init__(self, network=None, at=0):
        super().__init__(boards(), network)
        self.emulator = Emulator(self.network, None, self.counts[at].tolist(), REALISTIC, is_homed=False)
        self.bus = LocalBus(self.emulator, self.clock)
        self.executor._bus = self.executor.axes._bus = self.bus

    def home(self, at=0):
        Homing(self.network, self.counts[at]).declare(self.bus, self.clock)

    def motors(self):
        return np.array([drive.axis.actual for drive in self.emulator.drives.values()])


def changed(kind="epos2", drives=None, slider=None):
    made = network_of(boards(), kind, slider=kind)
    spec = made.spec.model_dump(by_alias=True)
    spec["drives"] |= drives or {}
    spec["slider"] |= slider or {}
    return Network(type(made.spec).model_validate(spec), boards().robot, "bench")


def test_drives_whose_supply_came_on_are_not_enabled():
    rig = New(at=20)
    rig.executor.arm()
    with pytest.raises(InfeasibleError, match=r"no axis knows where it is.*hognose home PLAN --network FILE"):
        rig.executor.hold()
    assert {drive.state for drive in rig.emulator.drives.values()} == {State.SWITCH_ON_DISABLED}


def test_one_drive_that_lost_its_supply_between_runs_is_named():
    """It says 0, which is within what is taken up as slack: only bit 15 tells."""
    rig = Rig(boards())
    rig.emulator.inject(Fault(7, "power_lost"))
    rig.executor.arm()
    assert rig.executor.axes.position[6] == 0
    assert abs(rig.counts[0, 6]) * boards().robot.travel_per_count[6] < 5e-3
    with pytest.raises(InfeasibleError, match=r"^cable 7 \(node 7\) does not know where it is: the drive says"):
        rig.executor.hold()
    assert rig.executor.phase is Phase.ARMED


@pytest.mark.parametrize("kind", ["epos2", "cia402"])
def test_drives_are_told_where_they_are_and_do_not_move(kind):
    rig = New(changed(kind), at=12)
    distance = 0x607C if kind == "epos2" else 0x30B1
    for drive in rig.emulator.drives.values():
        drive.objects[distance, 0].value = 5000  # of someone who homed before
    before = rig.motors()
    rig.home(at=12)
    np.testing.assert_array_equal(rig.motors(), before)
    assert {drive.state.has_power for drive in rig.emulator.drives.values()} == {False}
    rig.executor.arm()
    np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[12])
    rig.executor.hold()
    rig.executor.tension(12.0)
    assert rig.executor.run(14.0).trouble is None
    np.testing.assert_allclose(rig.motors(), rig.counts[14], atol=20)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (
            lambda drive: setattr(drive, "state", State.OPERATION_ENABLED),
            "is in operation enabled; drives are homed at",
        ),
        (lambda drive: drive.fault(0x8611), "is in fault; drives are homed at rest"),
        (lambda drive: setattr(drive.objects[0x1018, 1], "value", 0x5B), r"is no drive of maxon \(vendor 0x5B\)"),
        (lambda drive: drive.objects.pop((0x6098, 0)), "0x6098:0: there is no such object"),
    ],
)
def test_if_one_drive_cannot_be_homed_none_is(spoil, said):
    rig = New()
    for axis in (4, 36):
        spoil(rig.drive(axis))
    with pytest.raises(InputError) as caught:
        rig.home()
    words = str(caught.value)
    assert words.count("(node ") == 2
    assert f"cable 5 (node 5): {said}".replace("\\", "") in words
    assert "the slider (node 37): " in words
    assert "nothing was declared" in words
    assert not any(drive.encoder.is_referenced for drive in rig.emulator.drives.values())


def test_if_one_drive_fails_while_all_are_homed_all_start_anew():
    rig = New()
    rig.drive(9).encoder.home = lambda axis, objects, kind: None
    with pytest.raises(InputError) as caught:
        rig.home()
    assert "cable 10 (node 10): does not come to be homed: it is in operation enabled" in str(caught.value)
    assert "so none was homed: all drives were started anew" in str(caught.value)
    assert not any(drive.encoder.is_referenced for drive in rig.emulator.drives.values())
    assert not any(drive.state.has_power for drive in rig.emulator.drives.values())


class KilledError(Exception):
    pass


@pytest.mark.parametrize("at_once", [True, False])
def test_no_drive_counts_by_where_it_was_homed_before(at_once):
    """Whether the program is killed between two drives, or an error in it is the end of it."""
    rig = New()
    rig.home()
    whole, told = rig.bus.send, []

    def send(frames):
        if told and at_once:
            return  # it is gone
        whole(frames)
        if any(frame.cob == 0x605 and frame.data[:5] == bytes.fromhex("2b4060001f") for frame in frames):
            told.append(rig.clock.now())
            raise KilledError

    rig.bus.send = send
    with pytest.raises(KilledError):
        rig.home(at=30)
    assert told
    for axis in range(37):
        encoder, drive = rig.drive(axis).encoder, rig.drive(axis)
        says = encoder.says(drive.axis.actual)
        assert not encoder.is_referenced or (at_once and abs(says - rig.counts[30, axis]) <= 1)
    assert sum(rig.drive(axis).encoder.is_referenced for axis in range(37)) < (37 if at_once else 1)


def test_a_motor_that_turns_is_not_homed():
    rig = New()
    rig.clock.attach(lambda now: setattr(rig.drive(2).axis, "actual", 3e5 * now))
    with pytest.raises(InputError, match=r"cable 3 \(node 3\): is turning: [\d,]+ counts meanwhile"):
        rig.home()


def test_absolute_encoders_keep_where_they_are_with_their_zeros():
    zeros = [100 * k - 1000 for k in range(36)]
    network = changed(drives={"position": "absolute", "zeros": zeros}, slider={"position": "absolute", "zero": 777})
    rig = New(network)
    np.testing.assert_array_equal(rig.counts[0], [*(boards().motor_counts[0] + zeros), 777])
    found = zeros_of(rig.bus, rig.clock, changed(), changed().counts_of(boards())[0])
    np.testing.assert_array_equal(found, [*zeros, 777])
    with pytest.raises(InputError, match='axes with position = "absolute" are not homed'):
        rig.home()
    recorder, rows = Recorder(rig.clock), []
    writer = SimpleNamespace(fault=None, cycle=rows.append, event=lambda *given: None)
    recorder.begin(cast("Any", writer), rig.executor)
    rig.at_cycle.append(recorder.cycle)
    rig.ready()
    rows.clear()
    assert rig.executor.run(3.0).trouble is None
    np.testing.assert_allclose(rig.motors(), rig.counts[3], atol=20)
    # The record has what the plan has.
    (at_two,) = [row for row in rows if row.progress == 2.0]
    np.testing.assert_array_equal(at_two.commanded, boards().motor_counts[2])
    assert at_two.slider_commanded == pytest.approx(boards().feed[2], abs=1e-6)
    np.testing.assert_allclose(rows[-1].measured, boards().motor_counts[3], atol=20)


def test_what_is_wrong_with_all_drives_is_one_sentence():
    rig = New()
    for drive in rig.emulator.drives.values():
        drive.fault(0x8611)
    with pytest.raises(InputError) as caught:
        rig.home()
    assert "cable 5 (node 5) and 32 more: is in fault; drives are homed at rest" in str(caught.value)
    assert len(str(caught.value).splitlines()) == 2


def test_limits_are_judged_with_zeros():
    plan = boards()
    highest = int(plan.motor_counts.max())
    changed(drives={"highest_counts": highest}).refuse(plan)
    network = changed(drives={"highest_counts": highest, "zeros": [50] * 36})
    with pytest.raises(InputError, match=r"its zero of 50 included, but its axis ends at .*: 50 counts too far"):
        network.refuse(plan)
    far = round(float(plan.feed.max()) * 1e6)
    with pytest.raises(InputError, match=r"the slider \(node 37\) would go to .* at step 312, .*: 30 counts too far"):
        changed(slider={"highest_counts": far - 30}).refuse(plan)
    with pytest.raises(ValueError, match="`zeros` are 3, but `nodes` are 36"):
        changed(drives={"zeros": [1, 2, 3]})


def calibrated(tmp_path, chi2=70.0, fingerprint=None):
    """A network file that names a calibration in which cable 1 is 0.1 mm longer than its motor says."""
    robot, zeros = boards().robot, np.zeros(36)
    zeros[0] = 1e-4
    fit = Fit(zeros, np.ones(12), np.eye(48) * 1e-12, chi2, 72, 4)
    made = Calibration.made(robot, "tip", fit, Accuracy(), Prior(), 12)
    dataclasses.replace(made, fingerprint=fingerprint or robot.fingerprint).save(tmp_path / "arm.json")
    file = tmp_path / "bench.toml"
    file.write_text(
        'schema = 1\nunits = "mm"\nname = "bench"\nrobot = "sjtu-25dof"\n[bus]\ninterface = "virtual"\n[drives]\n'
        f'nodes = {list(range(1, 37))}\nnewton_per_unit = 0.1\ncalibration = "arm.json"\nzeros = {[5] * 36}\n'
        '[slider]\nkind = "cia402"\nnode = 40\ncounts_per_metre = 1e6\n'
    )
    return file


def test_a_cable_that_is_longer_than_its_motor_says_is_paid_out_less(tmp_path):
    plan = boards()
    network = load_network(calibrated(tmp_path))
    less = round(1e-4 / plan.robot.travel_per_count[0])
    assert less > 100
    assert network.zeros.tolist() == [5 - less, *[5] * 35, 0]
    lengths = plan.robot.lengths_of_counts(network.counts_of(plan)[:, :36] - 5)
    planned = plan.robot.lengths_of_counts(plan.motor_counts)
    np.testing.assert_allclose((planned - lengths)[:, 0], 1e-4, atol=1e-6)


def test_calibrations_of_another_arm_or_that_do_not_fit_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"bench\.toml: drives\.calibration: calibration: it is of robot"):
        load_network(calibrated(tmp_path, fingerprint="0" * 16))
    with pytest.raises(InputError, match=r"its readings do not fit the arm \(χ² 900 of 72 values\)"):
        load_network(calibrated(tmp_path, chi2=900.0))
    (tmp_path / "arm.json").unlink()
    with pytest.raises(InputError, match=r"drives\.calibration: .*no such file"):
        load_network(tmp_path / "bench.toml")
