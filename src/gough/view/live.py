"""The moving machine in a browser of this computer: viser on 127.0.0.1, with time, play, speed and magnification."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from .page import legend
from .scene import Scene
from .stage import Stage

HOST = "127.0.0.1"
SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "5", "10")
PERIOD = 1 / 30  # s between frames


class Live:
    """Scenes shown one at a time on one server; whoever made it calls `run`, or `frame` for each picture."""

    def __init__(self, server: Any, scenes: Sequence[Scene], names: Sequence[str], magnify: float | None = None):
        self.server, self.scenes, self.names = server, list(scenes), list(names)
        self.lock = threading.RLock()  # viser calls back from threads of its own
        self.stopped = threading.Event()
        self.playing, self.shown, self.magnified = False, -1, magnify
        self.stage = self._stage(0)
        self._panel()

    def _stage(self, number: int) -> Stage:
        self.server.scene.reset()
        stage = Stage(self.server, self.scenes[number])
        position, target = stage.camera()
        self.server.initial_camera.position, self.server.initial_camera.look_at = tuple(position), tuple(target)
        return stage

    def _panel(self) -> None:
        gui, scene = self.server.gui, self.stage.scene
        gui.configure_theme(show_logo=False, show_share_button=False)  # sharing would open a tunnel to the world
        times = scene.fitting if self.magnified is None else self.magnified
        self.told = gui.add_html(self._legend(times))
        if len(self.scenes) > 1:
            self.chosen = gui.add_dropdown("run", [f"{i + 1}: {name}" for i, name in enumerate(self.names)])
            self.chosen.on_update(lambda _: self._choose())
        self.time = gui.add_slider("time [s]", 0.0, max(scene.duration, 1e-6), self._step(scene), 0.0)
        self.play = gui.add_button("Play")
        self.speed = gui.add_dropdown("speed", [f"{s} x" for s in SPEEDS], initial_value="1 x")
        top = float(np.ceil(np.log10(max(times, scene.fitting, 10)))) + 1
        self.times = gui.add_slider("magnify, 10^", 0.0, top, 0.1, round(float(np.log10(times)), 1))
        self.forces = gui.add_checkbox("colour by force", True)
        self.marks = gui.add_checkbox("reversals", True)
        self.now = gui.add_html("")
        self.time.on_update(lambda _: self.frame())
        self.play.on_click(lambda _: self._play())
        self.times.on_update(lambda _: self._magnify())
        self.forces.on_update(lambda _: self._colour())
        self.marks.on_update(lambda _: self.stage.mark(self.marks.value))
        if self.magnified is not None:
            self.stage.magnify(times)
        self.frame()

    @staticmethod
    def _step(scene: Scene) -> float:
        return max(float(np.median(np.diff(scene.t))), scene.duration / 5000, 1e-6)

    def _legend(self, times: float) -> str:
        text = legend(self.stage.scene, times, over=False)
        return f"<div style='font-size:12px;line-height:1.5;padding:4px 12px'>{text}</div>"

    def _choose(self) -> None:
        with self.lock:
            number = int(self.chosen.value.partition(":")[0]) - 1
            self.stage, self.shown = self._stage(number), -1
            self.time.max = max(self.stage.scene.duration, 1e-6)
            self.time.value = min(self.time.value, self.time.max)
            self._magnify()
            self._colour()

    def _magnify(self) -> None:
        with self.lock:
            times = float(f"{10**self.times.value:.2g}")
            self.stage.magnify(times)
            self.told.content = self._legend(times)

    def _colour(self) -> None:
        with self.lock:
            self.stage.by_force, self.shown = self.forces.value, -1
            self.frame()

    def _play(self) -> None:
        with self.lock:
            self.playing = not self.playing
            if self.playing and self.time.value >= self.time.max - 1e-9:
                self.time.value = 0.0
            self.play.label = "Pause" if self.playing else "Play"

    def frame(self) -> None:
        """Show the machine at the slider's time."""
        with self.lock:
            scene = self.stage.scene
            row = scene.row(scene.t[0] + self.time.value)
            if row == self.shown:
                return
            self.shown = row
            with self.server.atomic():
                self.stage.show(row)
            error = 1e6 * scene.error[row]
            error = f"{error:.3g} µm" if np.isfinite(error) else "not known"
            self.now.content = f"<div style='font-size:12px;padding:4px 12px'>contour error {error}</div>"

    def run(self) -> None:
        """Play when asked to, until `stop`."""
        last = time.perf_counter()
        while not self.stopped.wait(PERIOD):
            now = time.perf_counter()
            if self.playing:
                with self.lock:
                    ahead = (now - last) * float(self.speed.value.split()[0])
                    self.time.value = min(self.time.value + ahead, self.time.max)
                    if self.time.value >= self.time.max:
                        self._play()
                self.frame()
            last = now

    def stop(self) -> None:
        self.stopped.set()
