"""`hognose home`: says what it declares, asks, and then drives may be run."""

import json

import pytest

import hognose
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.motions import counts_of
from hognose.drive.network import emulated_network

pytestmark = pytest.mark.slow
FILE = """schema = 1
units = "mm"
name = "bench"
robot = "sjtu-25dof"
[bus]
interface = "hognose"
channel = "{channel}"
most_load = 1.0
[drives]
nodes = {nodes}
newton_per_unit = 0.1
[slider]
kind = "epos2"
node = 37
counts_per_metre = 1e6
"""


def powered_on() -> Emulator:
    """Drives whose supply came on where the plan begins, in a process of their own."""
    plan = hognose.plan(hognose.load_task("obstacle-array"))
    network = emulated_network(plan.robot)
    return Emulator(network, start=counts_of(plan, network)[0].tolist(), is_homed=False)


def test_drives_are_homed_and_run_only_then(run, tmp_path):
    plan, file = tmp_path / "boards.parquet", tmp_path / "bench.toml"
    hognose.plan(hognose.load_task("obstacle-array")).save(plan)
    process = EmulatorProcess(powered_on)
    file.write_text(FILE.format(channel=process.channel, nodes=list(range(1, 37))))
    try:
        refused = run("run", plan, "--network", file, "--yes", "--record", tmp_path / "no.mcap")
        assert refused.code == 1
        assert "no axis knows where it is: the drive says that its position is not referenced" in refused.err
        asked = run("home", plan, "--network", file)
        assert asked.code == 2
        assert "positions are declared only after a confirmation at a terminal; give --yes" in asked.err
        read = run("home", plan, "--network", file, "--zeros", "--json")
        counts = hognose.planning.Plan.load(plan).motor_counts
        assert json.loads(read.out)["zeros"] == [*(-counts[0]).tolist(), 0]
        done = run("home", plan, "--network", file, "--yes")
        assert (done.code, done.err) == (0, "")
        assert done.out.startswith("GOOD: 37 drives say that they are where ")
        assert json.loads(run("home", plan, "--network", file, "--zeros", "--json").out)["zeros"] == [0] * 37
    finally:
        process.close()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--at", "313"), "at: expected a step of the plan from 0 to 312, got 313"),
        (("--at", "-1"), "at: expected a step of the plan from 0 to 312, got -1"),
    ],
)
def test_steps_that_are_not_there_are_refused(run, tmp_path, options, said):
    plan, file = tmp_path / "boards.parquet", tmp_path / "bench.toml"
    hognose.plan(hognose.load_task("obstacle-array")).save(plan)
    file.write_text(FILE.format(channel="127.0.0.1:1", nodes=list(range(1, 37))))
    done = run("home", plan, "--network", file, "--yes", *options)
    assert done.code == 2
    assert said in done.err
