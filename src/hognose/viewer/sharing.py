"""Taking with you what is seen: a recording that needs no server, a picture, a video, the report."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path as FilePath
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from hognose.errors import HognoseError
from hognose.planning import Plan
from hognose.report.camera import Camera, view_axes
from hognose.viewer.model.arm_state import ArmState
from hognose.viewer.model.saving import file_stem
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.stage import Stage

if TYPE_CHECKING:
    import viser

Progress = Callable[[int, int], None]

#: A recording shows so many rows of a plan at most, and plays about this many a second.
MOST_FRAMES, FRAME_RATE = 300, 20.0
SIZES = {"1280 × 720": (1280, 720), "1920 × 1080": (1920, 1080), "640 × 360": (640, 360)}


def recording(server: viser.ViserServer, stage: Stage, plan: Plan) -> bytes:
    """One HTML page with the whole motion in it, that opens without a server; the caller alone draws meanwhile."""
    frames = min(len(plan.feed), MOST_FRAMES)
    serializer = server.get_scene_serializer()
    for row in np.unique(np.linspace(0, len(plan.feed) - 1, frames).astype(int)):
        stage.walls.move(plan.task.moving, float(plan.clock[row]))
        stage.show(ArmState.of_plan(plan, int(row)))
        server.flush()
        serializer.insert_sleep(1.0 / FRAME_RATE)
    return serializer.as_html().encode()


def picture(client: viser.ClientHandle, size: tuple[int, int]) -> bytes:
    """What a browser shows, as PNG of a size in pixels."""
    from PIL import Image

    width, height = size
    stream = io.BytesIO()
    Image.fromarray(client.get_render(height=height, width=width)).save(stream, format="PNG")
    return stream.getvalue()


def seen_from(client: viser.ClientHandle) -> Camera:
    """From where a browser looks."""
    seen = client.camera
    return Camera(
        np.array(seen.position, dtype=np.float64),
        view_axes(np.asarray(seen.position) - np.asarray(seen.look_at), seen.up_direction),
        float(np.tan(seen.fov / 2)),
    )


class Sharing:
    """Buttons that make files and hand them to the browser that asked.

    Parameters
    ----------
    server, stage, gui
    bench
        Whose motion is shared: that of the task as it is now, or none.
    say
        Shows a sentence.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        stage: Stage,
        gui: viser.GuiApi,
        bench: Workbench,
        say: Callable[[str], None],
    ) -> None:
        self._server, self._stage, self._bench, self._say = server, stage, bench, say
        self._wanted: SimpleQueue[tuple[viser.ClientHandle, Plan]] = SimpleQueue()
        self._size = gui.add_dropdown("size of pictures", tuple(SIZES), initial_value=next(iter(SIZES)))
        gui.add_button("Recording (HTML)", hint="one page, needs no server").on_click(self._recording_asked)
        gui.add_button("Picture (PNG)", hint="the current view in this browser").on_click(self._picture)
        gui.add_button("Video (MP4)", hint="the whole motion, from the current camera").on_click(self._video)
        gui.add_button("Report (HTML)").on_click(self._report)

    @property
    def asked(self) -> bool:
        """Whether somebody waits for a recording."""
        return not self._wanted.empty()

    def record(self, draw: Callable[[Plan], None]) -> None:
        """Make the recordings that were asked for, of the plans that were the task's then. For the page's thread.

        `draw` shows what does not move of a plan; the stage shows another row afterwards.
        """
        made: dict[Plan, bytes] = {}
        while self.asked:
            client, plan = self._wanted.get()
            if plan not in made:
                draw(plan)
                made[plan] = recording(self._server, self._stage, plan)
            name = f"{file_stem(plan.task.name)}-recording.html"
            client.send_file_download(name, made[plan], save_immediately=True)

    def _asked_by(self, event: viser.GuiEvent) -> tuple[viser.ClientHandle, Plan] | None:
        """Who asked, and the task's plan as it is now; None if there is none, which is said."""
        verdict = self._bench.current
        if verdict is None:
            self._say("the task is still being planned; try again when its verdict is shown")
        elif verdict.plan is None:
            self._say(f"there is no motion to share: {verdict.headline}")
        elif event.client is not None:
            return event.client, verdict.plan
        return None

    def _recording_asked(self, event: viser.GuiEvent) -> None:
        if asked := self._asked_by(event):
            self._wanted.put(asked)

    def _picture(self, event: viser.GuiEvent) -> None:
        from PIL.Image import DecompressionBombError

        if asked := self._asked_by(event):
            client, plan = asked
            try:
                png = picture(client, SIZES[self._size.value])
            except RuntimeError:
                return  # the browser is gone, and with it who wanted the picture
            except (OSError, ValueError, DecompressionBombError):
                self._say("the browser sent an unreadable picture; reload the page and try again")
                return
            client.send_file_download(f"{file_stem(plan.task.name)}.png", png, save_immediately=True)

    def _video(self, event: viser.GuiEvent) -> None:
        from hognose.report.animation import animate

        def make(client: viser.ClientHandle, plan: Plan, file: FilePath, progress: Progress) -> None:
            animate(plan, file, size=SIZES[self._size.value], camera=seen_from(client), progress=progress)

        self._made(event, "video", "mp4", make)

    def _report(self, event: viser.GuiEvent) -> None:
        from hognose.report.report import write_report

        self._made(event, "report", "html", lambda _, plan, file, progress: write_report(plan, file, progress=progress))

    def _made(
        self,
        event: viser.GuiEvent,
        what: str,
        suffix: str,
        make: Callable[[viser.ClientHandle, Plan, FilePath, Progress], object],
    ) -> None:
        """Make a file with what makes files, and hand it over."""
        asked = self._asked_by(event)
        if asked is None:
            return
        client, plan = asked
        shown = client.add_notification("Hognose", f"drawing the {what}", loading=True, with_close_button=False)

        def progress(done: int, of: int) -> None:
            shown.body = f"drawing the {what}: {done} of {of}"

        with TemporaryDirectory() as folder:
            file = FilePath(folder) / f"{file_stem(plan.task.name)}.{suffix}"
            try:
                make(client, plan, file, progress)
                client.send_file_download(file.name, file.read_bytes(), save_immediately=True)
            except HognoseError as error:
                self._say(str(error))
            finally:
                shown.remove()
