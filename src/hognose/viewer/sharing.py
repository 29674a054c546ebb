"""Taking with you what is seen: a recording that needs no server, a picture, a video, the report."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from hognose.errors import HognoseError
from hognose.planning import Plan
from hognose.viewer.pose import Pose
from hognose.viewer.saving import file_stem
from hognose.viewer.stage import Stage

if TYPE_CHECKING:
    import viser

#: A recording shows so many rows of a plan at most, and plays about this many a second.
MOST_FRAMES, FRAME_RATE = 300, 20.0
SIZES = {"1280 × 720": (1280, 720), "1920 × 1080": (1920, 1080), "640 × 360": (640, 360)}


def recording(server: viser.ViserServer, stage: Stage, plan: Plan) -> bytes:
    """One HTML page with the whole motion in it, that opens without a server; the caller alone draws meanwhile."""
    frames = min(len(plan.feed), MOST_FRAMES)
    serializer = server.get_scene_serializer()
    for row in np.unique(np.linspace(0, len(plan.feed) - 1, frames).astype(int)):
        stage.show(Pose.of_plan(plan, int(row)))
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


class Sharing:
    """Buttons that make files and hand them to the browser that asked.

    Parameters
    ----------
    server, stage, gui
    plan_shown
        The plan on the page, or None.
    say
        Shows a sentence.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        stage: Stage,
        gui: viser.GuiApi,
        plan_shown: Callable[[], Plan | None],
        say: Callable[[str], None],
    ) -> None:
        self._server, self._stage, self._plan, self._say = server, stage, plan_shown, say
        self._wanted: list[viser.ClientHandle] = []
        self._size = gui.add_dropdown("size of pictures", tuple(SIZES), initial_value=next(iter(SIZES)))
        gui.add_button("Recording (HTML)", hint="one page, opens anywhere, offline").on_click(self._recording_asked)
        gui.add_button("Picture (PNG)", hint="as this browser shows it").on_click(self._picture)
        gui.add_button("Video (MP4)", hint="the renderer of the reports").on_click(self._video)
        gui.add_button("Report (HTML)").on_click(self._report)

    def update(self) -> bool:
        """Make the recordings that were asked for; True if the stage shows another row now. The page's thread calls."""
        plan, wanted = self._plan(), self._wanted
        if not wanted or plan is None:
            return False
        self._wanted = []
        page = recording(self._server, self._stage, plan)
        for client in wanted:
            client.send_file_download(f"{file_stem(plan.task.name)}-recording.html", page, save_immediately=True)
        return True

    def _recording_asked(self, event: viser.GuiEvent) -> None:
        if event.client is not None and self._plan() is not None:
            self._wanted = [*self._wanted, event.client]

    def _picture(self, event: viser.GuiEvent) -> None:
        plan = self._plan()
        if event.client is not None and plan is not None:
            png = picture(event.client, SIZES[self._size.value])
            event.client.send_file_download(f"{file_stem(plan.task.name)}.png", png, save_immediately=True)

    def _video(self, event: viser.GuiEvent) -> None:
        from hognose.view.animation import animate

        size = SIZES[self._size.value]
        self._made(event, "video", "mp4", lambda plan, file: animate(plan, file, size=size))

    def _report(self, event: viser.GuiEvent) -> None:
        from hognose.view.report import write_report

        self._made(event, "report", "html", lambda plan, file: write_report(plan, file))

    def _made(self, event: viser.GuiEvent, what: str, suffix: str, make: Callable[[Plan, FilePath], object]) -> None:
        """Make a file with what makes files, and hand it over."""
        plan = self._plan()
        if event.client is None or plan is None:
            return
        self._say(f"drawing the {what}; it takes some seconds")
        with TemporaryDirectory() as folder:
            file = FilePath(folder) / f"{file_stem(plan.task.name)}.{suffix}"
            try:
                make(plan, file)
            except HognoseError as error:
                self._say(str(error))
                return
            event.client.send_file_download(file.name, file.read_bytes(), save_immediately=True)
