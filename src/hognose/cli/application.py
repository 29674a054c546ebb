"""The commands, as one application."""

from __future__ import annotations

from cyclopts import App

from hognose import __version__
from hognose.cli.bench import bench
from hognose.cli.calibrate import calibrate
from hognose.cli.check import check
from hognose.cli.completion import installer_of
from hognose.cli.demo import demo
from hognose.cli.emulate import emulate
from hognose.cli.export import export
from hognose.cli.home import home
from hognose.cli.log import log
from hognose.cli.mechanics import mechanics
from hognose.cli.methods import methods
from hognose.cli.new import new
from hognose.cli.plan import plan
from hognose.cli.report import report
from hognose.cli.robot import robot
from hognose.cli.run import run
from hognose.cli.scene import scene
from hognose.cli.simulate import simulate
from hognose.cli.tolerance import tolerance
from hognose.cli.view import view
from hognose.cli.watch import watch

#: Commands that leave a file or a verdict, so that their output may go nowhere.
LEAVE_MORE_THAN_OUTPUT = (
    "plan",
    "check",
    "calibrate",
    "simulate",
    "run",
    "home",
    "export",
    "report",
    "bench",
    "demo",
    "new",
)

app = App(
    name="hognose",
    help="Plan, verify, show and export motions of snake-arm robots through confined spaces.",
    version=__version__,
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
for command in (
    new,
    plan,
    check,
    view,
    export,
    report,
    robot,
    scene,
    tolerance,
    mechanics,
    calibrate,
    simulate,
    run,
    emulate,
    watch,
    home,
    log,
    methods,
    bench,
    demo,
):
    app.command(command)
app.command(installer_of(app), name="--install-completion")
