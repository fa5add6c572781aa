"""Shows a run while it goes on: the page comes from a server of this process, its frames as server-sent events."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
from fmpy.fmi2 import FMU2Slave

from sigmafmu import SigmafmuError
from sigmafmu.contents.scene_of import Scene
from sigmafmu.model import Model
from sigmafmu.recorder import Reader
from sigmafmu.result import Result, Statistics
from sigmafmu.variables import select
from sigmafmu.view.motion import motion_of, variables_of
from sigmafmu.view.page import page

HERE = "127.0.0.1"
PATIENCE = 60.0
"""Seconds until the page must be open, and until it must have got the last frame."""


@dataclass
class _Frames:
    """What was read at each of `time`; the run adds it, and each browser gets what is there."""

    scene: Scene
    names: tuple[str, ...]
    reader: Reader
    time: np.ndarray
    rows: list[np.ndarray] = field(default_factory=list)
    ended: bool = False
    opened: bool = False
    watching: int = 0
    changed: threading.Condition = field(default_factory=threading.Condition)

    def result(self, name: str, row: np.ndarray, time: np.ndarray) -> Result:
        """The mechanism as it is in a row, at all of `time`."""
        values = np.repeat(row[None], len(time), axis=0)
        return Result(name, time, self.names, values, Statistics(float(np.ptp(time)), 0.0, len(time)))

    def poses(self, i: int) -> list[list[float]]:
        """Of each body and moving frame: position, quaternion and modal coordinates."""
        motion = motion_of(self.result("", self.rows[i], self.time[i : i + 1]), self.scene.layout, ())
        tracks = motion.bodies.values()
        return [[*track.position[0], *track.quaternion[0], *track.modal[0]] for track in tracks]

    def read(self) -> np.ndarray:
        """What the FMU has now."""
        self.reader.read()
        return self.reader.rows()[0]

    def add(self) -> None:
        """The next frame."""
        row = self.read()
        with self.changed:
            self.rows.append(row)
            self.changed.notify_all()

    def events(self) -> Iterator[str]:
        """The frames as they come, then the end."""
        for i in range(len(self.time)):
            with self.changed:
                self.changed.wait_for(lambda i=i: len(self.rows) > i or self.ended)
                if len(self.rows) == i:
                    break
            yield f"data: {json.dumps({'frame': i, 'poses': self.poses(i)})}\n\n"
        yield "event: end\ndata: \n\n"


@contextmanager
def live(
    scene: Scene, model: Model, slave: FMU2Slave, time: np.ndarray, opening: Callable[[str], None]
) -> Iterator[Callable[[], None]]:
    """Serve a page at an address of this machine, which `opening` gets, and wait until a browser has it.

    Gives a function that reads the next frame, of those at `time` [s]. At the end the page has all and needs no server.
    Raises SigmafmuError if no browser comes.
    """
    wanted = [name for name in variables_of(scene.layout) if not name.endswith(".angularVelocity")]
    variables = select(model.fmu, wanted)
    frames = _Frames(scene, tuple(v.name for v in variables), Reader(slave, variables), time)
    text = page(scene, frames.result(model.name, frames.read(), time), live=True).encode()
    server = ThreadingHTTPServer((HERE, 0), _handler(frames, text))
    server.daemon_threads = True
    address = f"{HERE}:{server.server_address[1]}"
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        opening(f"http://{address}/")
        with frames.changed:
            if not frames.changed.wait_for(lambda: frames.opened, PATIENCE):
                raise SigmafmuError(f"no browser has opened http://{address}/ within {PATIENCE:g} s")
        yield frames.add
    finally:
        with frames.changed:
            frames.ended = True
            frames.changed.notify_all()
            frames.changed.wait_for(lambda: not frames.watching, PATIENCE)
        server.shutdown()
        server.server_close()


def _handler(frames: _Frames, text: bytes) -> type[BaseHTTPRequestHandler]:
    """Answers requests for the page and for its events."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            own = f"{HERE}:{self.server.server_address[1]}"
            if self.headers["Host"] != own:  # a page of elsewhere whose name leads here
                self.send_error(403)
            elif self.path == "/":
                self._begin("text/html; charset=utf-8")
                self.wfile.write(text)
            elif self.path == "/events":
                self._begin("text/event-stream")
                self._events()
            else:
                self.send_error(404)

        def _begin(self, kind: str) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Cache-Control", "no-store")
            self.end_headers()

        def _events(self) -> None:
            with frames.changed:
                frames.opened, frames.watching = True, frames.watching + 1
                frames.changed.notify_all()
            try:
                for event in frames.events():
                    self.wfile.write(event.encode())
                    self.wfile.flush()
            except OSError:  # the page was closed
                pass
            finally:
                with frames.changed:
                    frames.watching -= 1
                    frames.changed.notify_all()

        def log_message(self, *_: object) -> None:
            """Nothing on the terminal."""

    return Handler
