"""Network files: what is wrong in one is said in a sentence before anything moves."""

import dataclasses

import pytest
from drive_makers import boards, network_of

import hognose
from hognose.drive.bus_load import bus_load, frame_bits
from hognose.drive.network import Network, emulated_network, load_network
from hognose.errors import InputError
from hognose.robot import Robot, RobotSpec

FILE = """schema = 1
units = "mm"
name = "bench"
robot = "sjtu-25dof"
{top}
[bus]
interface = "socketcan"
channel = "can0"
{bus}
[drives]
nodes = {nodes}
newton_per_unit = 0.1
{drives}
[slider]
{slider}
"""
SLIDER = 'kind = "cia402"\nnode = 40\ncounts_per_metre = 1e6'


def written(tmp_path, nodes=tuple(range(1, 37)), **parts):
    file = tmp_path / "bench.toml"
    given = {"top": "", "bus": "", "drives": "", "slider": SLIDER} | parts
    file.write_text(FILE.format(nodes=list(nodes), **given))
    return file


def test_a_network_file_says_which_node_drives_which_cable(tmp_path):
    network = load_network(written(tmp_path, nodes=range(36, 0, -1)))
    assert network.nodes == (*range(36, 0, -1), 40)
    assert network.axis_name(0) == "cable 1 (node 36)"
    assert network.axis_name(36) == "the slider (node 40)"
    assert network.cycles_of(boards()) == 5
    network.refuse(boards())


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"nodes": (*range(1, 36), 7)}, "node 7 is there twice, for cables 7 and 36"),
        ({"nodes": range(1, 36)}, "35 nodes, but sjtu-25dof has 36 cables; give the node of the drive of every cable"),
        ({"nodes": (*range(1, 36), 127)}, "less than or equal to 126"),
        ({"slider": SLIDER.replace("node = 40", "node = 12")}, "slider: node 12 is the drive of cable 12 already"),
        ({"slider": 'kind = "serial"\ncounts_per_metre = 1e6'}, "a slider on a serial board needs its `port`"),
        (
            {"top": "cycle_s = 0.015", "drives": "least_records = 10\nmost_records = 20"},
            r"the bus would be taken for \d+ % of the time, more than most_load of 80 %",
        ),
        ({"bus": "bitrate = 125000"}, r"raise bus.bitrate \(125,000 bit/s\)"),
        ({"drives": "least_records = 3"}, "Their buffers would run empty before that, and the power would be cut"),
        ({"drives": "bitrat = 3"}, "unknown key"),
    ],
)
def test_what_is_wrong_in_a_network_file_is_said(tmp_path, parts, said):
    with pytest.raises(InputError, match=said):
        load_network(written(tmp_path, **parts))


def test_a_plan_that_the_drives_cannot_follow_is_refused(tmp_path):
    plan = boards()
    short = load_network(written(tmp_path, drives="highest_counts = 20000"))
    with pytest.raises(
        InputError, match=r"cable \d+ \(node \d+\) would go to [\d,]+ counts at step \d+, but its axis ends at"
    ):
        short.refuse(plan)
    other = hognose.plan(hognose.load_task("detour"))
    network_of(plan).refuse(other)
    moving = hognose.plan(hognose.load_task("moving-obstacles"))
    with pytest.raises(InputError, match=r"moves\. Its times hold only for a motion that never pauses"):
        network_of(moving).refuse(moving)
    carried = hognose.plan(hognose.load_task("carrier"))
    with pytest.raises(InputError, match="carried by another robot, which has a controller of its own"):
        network_of(carried).refuse(carried)
    extending = hognose.load_task("baffled-tank")
    longer = hognose.plan(extending)
    with pytest.raises(InputError, match="sections of metabot-3arc change their length on the way, which their back"):
        network_of(longer).refuse(longer)
    motion = extending.spec.motion.model_copy(update={"method": "aim"})
    spec = extending.spec.model_copy(update={"motion": motion})
    resting = hognose.plan(dataclasses.replace(extending, spec=spec))
    network_of(resting).refuse(resting)


def test_the_load_is_that_of_all_frames_with_every_bit_that_can_be_stuffed():
    """A frame of 8 bytes has 111 bits, 24 stuffed at most: ISO 11898-1."""
    assert frame_bits(8) == 135
    assert frame_bits(0) == 55
    network = emulated_network(boards().robot)
    slow = network.spec.model_copy(update={"cycle_s": 0.06})
    assert bus_load(slow, 5) < network.load < 2 * bus_load(slow, 5)


def test_too_many_cables_for_a_bus_are_refused():
    spec = boards().robot.spec.model_dump(by_alias=True)
    spec["section"][0]["count"] = 42
    spec["cables"] = None
    longest = Robot.from_spec(RobotSpec.model_validate(spec))
    with pytest.raises(InputError, match="126 cables and a slider are more than the 126 nodes of a bus"):
        emulated_network(longest)


def test_periods_are_divided_into_whole_milliseconds():
    network = network_of(boards())
    assert isinstance(network, Network)
    plan = boards()

    def with_period(period):
        spec = plan.task.spec
        motion = spec.motion.model_copy(update={"period_s": period})
        return dataclasses.replace(plan, task=hognose.Task(spec.model_copy(update={"motion": motion}), plan.robot))

    for period, cycles in ((0.15, 5), (0.03, 1), (0.02, 1), (0.1, 4), (0.063, 3)):
        assert network.cycles_of(with_period(period)) == cycles
    with pytest.raises(InputError, match=r"a period of 33\.3 ms is no whole number of milliseconds"):
        network.cycles_of(with_period(0.0333))
    with pytest.raises(InputError, match="a period of 151 ms cannot be divided into whole milliseconds near cycle_s"):
        network.cycles_of(with_period(0.151))


def test_a_slider_on_a_serial_board_is_a_node_as_any_other(tmp_path):
    line = 'kind = "serial"\nport = "COM3"\ncounts_per_metre = 1e6'
    network = load_network(written(tmp_path, slider=line))
    assert (network.nodes[-1], network.kinds[-1], network.board_node) == (126, "cia402", 126)
    assert network.axis_name(36) == "the slider (board at COM3)"
    assert network.load == bus_load(network.spec.model_copy(update={"slider": None}), 5)
    network.refuse(boards())
    assert load_network(written(tmp_path, slider=line + "\nnode = 50")).board_node == 50
    with pytest.raises(InputError, match=r"node 126 is the drive of cable 36 already.*Give a board .* a free `node`"):
        load_network(written(tmp_path, nodes=(*range(1, 36), 126), slider=line))


@pytest.mark.parametrize("kind", ["cia402", "serial"])
def test_a_plan_beyond_where_the_slider_ends_is_refused(tmp_path, kind):
    slider = SLIDER.replace("cia402", kind) + "\nport = 'COM3'\nhighest_counts = 7500"
    with pytest.raises(InputError, match="would go to 1,089,013 counts at step 312, but its axis ends at -2,147"):
        load_network(written(tmp_path, slider=slider)).refuse(boards())
    with pytest.raises(InputError, match="`lowest_counts` must be below `highest_counts`"):
        load_network(written(tmp_path, slider=slider + "\nlowest_counts = 7500"))


@pytest.mark.parametrize(("cycle_s", "words"), [(0.02, "taken for 101 %"), (0.03, "")])
def test_what_bus_and_buffers_bear_is_judged_by_the_cycles_that_a_plan_really_has(cycle_s, words):
    plan = boards()
    made = emulated_network(plan.robot)
    bus = made.spec.bus.model_copy(update={"most_load": 0.8})
    spec = made.spec.model_copy(update={"cycle_s": cycle_s, "bus": bus})
    network = Network(
        type(spec).model_validate(
            spec.model_dump(by_alias=True)
            | {"drives": spec.drives.model_dump() | {"least_records": 8, "most_records": 12}}
        ),
        plan.robot,
        "net.toml",
    )
    if not words:
        network.refuse(plan)
        return
    with pytest.raises(InputError, match=rf"cycles of 15 ms, shorter than cycle_s of 20 ms.*{words}"):
        network.refuse(plan)
