"""Executors on emulated drives, in simulated time."""

from functools import cache

import numpy as np

import hognose
from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.emulator import Delays, Emulator
from hognose.drive.executor import Executor
from hognose.drive.local_bus import local_bus
from hognose.drive.motions import counts_of
from hognose.drive.network import Network, emulated_network
from hognose.drive.settings import Settings
from hognose.planning import Plan

#: Drives answer within 0.2 to 0.7 ms.
REALISTIC = Delays(2e-4, 5e-4)


@cache
def boards() -> Plan:
    return hognose.plan(hognose.load_task("obstacle-array"))


def network_of(plan: Plan, kind: str = "epos2", slider: str = "epos2", **watch) -> Network:
    """Emulated drives, of another kind or watched otherwise where asked for."""
    made = emulated_network(plan.robot)
    spec = made.spec.model_dump(by_alias=True)
    spec["drives"]["kind"], spec["slider"]["kind"] = kind, slider
    if slider == "serial":
        spec["slider"] |= {"node": None, "port": "socket://127.0.0.1:1"}
    spec["watch"] |= watch
    return Network(type(made.spec).model_validate(spec), plan.robot, made.source)


class Springs:
    """Cables that pull what is planned at the start of a plan, and 0.1 N less for each count that they are paid out."""

    def __init__(self, plan: Plan):
        assert plan.held is not None
        self._planned, self._begin = plan.held.tensions[0], plan.motor_counts[0]
        self.tensions = self._planned.copy()

    def sight(self):
        return None

    def move(self, counts, slider, dt):
        off = np.clip(counts - self._begin, 0.0, None)
        self.tensions = np.maximum(self._planned - 0.1 * np.where(off > 300.0, off, 0.0), 0.0)


class Rig:
    """A plan, its emulated drives and an executor; nothing was sent yet."""

    def __init__(
        self, plan: Plan, network: Network | None = None, delays: Delays = REALISTIC, seed: int = 0, **settings
    ):
        self.plan, self.network = plan, network or network_of(plan)
        self.counts = counts_of(plan, self.network)
        self.clock = SimulatedClock()
        plant = Springs(plan) if settings.get("watches_tension") else None
        self.emulator = Emulator(self.network, plant, self.counts[0].tolist(), delays, seed)
        self.cycles, self.events, self.at_cycle = [], [], []
        given = Settings(**({"watches_tension": False} | settings))
        self.bus = bus = local_bus(self.emulator, self.clock)
        self.executor = Executor(plan, self.network, bus, self.clock, given, self._seen, self._said)

    def _seen(self, cycle):
        self.cycles.append(cycle)
        for action in list(self.at_cycle):
            action(cycle)

    def _said(self, kind, words, axis):
        self.events.append((kind, words, axis))

    def ready(self):
        """Armed, holding, and where the plan begins."""
        self.executor.arm()
        self.executor.hold()
        self.executor.tension()
        self.cycles.clear()
        return self

    def tighten_on_the_way(self, cable, newton, step):
        """Let a cable pull so much more for every step that the arm is beyond a step."""
        plant, places = self.emulator._plant, [0.0]
        whole = plant.move
        self.at_cycle.append(lambda cycle: places.append(cycle.set_point.place))

        def move(counts, slider, dt):
            whole(counts, slider, dt)
            plant.tensions[cable] += newton * max(places[-1] - step, 0.0)

        plant.move = move

    def drive(self, axis):
        return self.emulator.drives[self.network.nodes[axis]]
