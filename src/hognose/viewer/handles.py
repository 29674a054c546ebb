"""Handles to drag way-points and the target by."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hognose.report.style import POINT, TIP
from hognose.viewer.shapes import rgb

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

#: Size of a handle's arrows and of the ball in it, as parts of the way's size.
ARROWS, BALL = 0.06, 0.009


class Handles:
    """One handle a stop of the way. Only the page's thread may show; drags are told in the browser's order.

    Parameters
    ----------
    server
    moved
        Called with the number of the stop and its new place (3,) m.
    chosen
        Called with the number of a stop that was clicked or grabbed.
    """

    def __init__(
        self, server: viser.ViserServer, moved: Callable[[int, Array], None], chosen: Callable[[int], None]
    ) -> None:
        self._scene = server.scene
        self._moved, self._chosen = moved, chosen
        self._controls: list[viser.TransformControlsHandle] = []
        self._balls: list[viser.IcosphereHandle] = []
        self._dragged: int | None = None
        self.visible = True
        server.on_client_disconnect(lambda _: self._release())

    def _release(self) -> None:
        """Whoever held one may be gone."""
        self._dragged = None

    def show(self, stops: Array) -> None:
        """Put handles at stops (m, 3) m; the one that a person holds stays where it is held."""
        if len(stops) != len(self._controls):
            self._make(stops)
        for k, place in enumerate(stops):
            if k != self._dragged and not np.allclose(self._controls[k].position, place, atol=1e-9):
                self._controls[k].position = place
            if not np.allclose(self._balls[k].position, place, atol=1e-9):
                self._balls[k].position = place

    def show_at_all(self, visible: bool) -> None:
        """Show or hide all handles."""
        self.visible = visible
        for handle in (*self._controls, *self._balls):
            handle.visible = visible

    def _make(self, stops: Array) -> None:
        for handle in (*self._controls, *self._balls):
            handle.remove()
        self._controls, self._balls, self._dragged = [], [], None
        size = float(np.linalg.norm(stops.max(axis=0) - stops.min(axis=0)))
        for k, place in enumerate(stops):
            last = k == len(stops) - 1
            control = self._scene.add_transform_controls(
                f"/stops/{k}",
                scale=ARROWS * size,
                line_width=3.0,
                disable_rotations=True,
                disable_sliders=True,
                depth_test=False,
                position=place,
                visible=self.visible,
            )
            ball = self._scene.add_icosphere(
                f"/stop_balls/{k}", radius=BALL * size, color=rgb(TIP if last else POINT), position=place
            )
            self._controls.append(control)
            self._balls.append(ball)
            self._connect(k, control)

    def _connect(self, number: int, control: viser.TransformControlsHandle) -> None:
        @control.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            if event.phase == "start":
                self._dragged = number
                self._chosen(number)
            elif event.phase == "end":
                self._dragged = None
            self._moved(number, np.array(control.position, dtype=np.float64))
