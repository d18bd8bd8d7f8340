"""The rerun viewer: a window for a person, or a picture without a display. It listens on this machine alone."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import socket
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from contactlab.api.drawing.colours import STATES, STYLES, rgb
from contactlab_rerun.opening import step_to_open

MAGIC = b"RRF"  # how recordings begin
HOST = "127.0.0.1"
SIZE = "1600x1000"
MEMORY = "2GB"  # unlimited, the viewer takes three quarters of the machine
MENU = 36  # pixels of the window's own bar, which is not part of the recording
PATIENCE = 60.0  # seconds until the viewer has loaded a recording; software renderers are slow
TRIES = 3  # the library waits 15 s for a picture
NUDGES = 20  # draw requests to the viewer while one waits
SETTLE = 5.0  # seconds for views to follow the cursor, and for messages of the first moments to go

NO_DRIVER = (
    "the viewer found no graphics driver; a software one serves: install mesa-vulkan-drivers and libvulkan1 (Debian, "
    "Ubuntu) or mesa-vulkan-drivers and vulkan-loader (Fedora)"
)


def in_cell(file: Path) -> Any:
    """A widget with the recording for a notebook's cell; None if there is no notebook, or no such widget."""
    if "ipykernel" not in sys.modules or find_spec("rerun_notebook") is None:
        return None
    from rerun.notebook import Viewer

    widget = Viewer(width=1000, height=640)
    widget._viewer.send_rrd(file.read_bytes())
    return widget


def open_window(file: Path) -> None:
    """Start the viewer with the recording and leave it running.

    Raises ValueError if `file` is not a recording, RuntimeError if the viewer cannot start.
    """
    check_recording(file)
    port, step = _free_port(), step_to_open(file)
    process = subprocess.Popen(
        [*_command(port), str(file)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )
    try:
        _, words = process.communicate(timeout=3.0)
    except subprocess.TimeoutExpired:
        if step is not None:
            # put the cursor of the running viewer at this step, if it answers
            from rerun.experimental import ViewerClient

            with contextlib.suppress(Exception):
                client = ViewerClient.connect(_url(port))
                _wait_for(client)
                client.set_time("step", sequence=step, play_state="paused")
        return
    if process.returncode:
        raise RuntimeError(f"{_last_words(words)}; without a display, --png FILE writes a picture")


def _url(port: int) -> str:
    return f"rerun+http://{HOST}:{port}/proxy"


def write_picture(file: Path, png: Path, step: int | None, iteration: int | None = None) -> None:
    """Write a picture of the recording at `step`, or where the recording opens: before a warning, else at its end.

    With `iteration` it shows Newton's iteration with this number among all of the run. Raises ValueError if
    `file` is not a recording or has no such step or iteration, RuntimeError if this machine cannot draw.
    """
    check_recording(file)
    with headless_viewer(file) as client:
        _wait_for(client)
        timeline, at = ("step", step) if iteration is None else ("iteration", iteration)
        first, last = _ends(client, timeline)
        if at is not None and not first <= at <= last:
            raise ValueError(f"{timeline}: got {at}, allowed: {first} to {last}, the {timeline}s of the recording")
        opens = step_to_open(file)
        at = at if at is not None else last if opens is None else opens
        for _ in range(NUDGES):  # each draws again: on a busy machine the messages would else not go with time
            client.set_time(timeline, sequence=at, play_state="paused")
            sleep(SETTLE / NUDGES)
        with tempfile.TemporaryDirectory() as folder:
            shot = Path(folder) / "picture.png"
            _save(client, shot)
            _publish(shot, png)
        for error in view_errors(client):
            warnings.warn(f"the viewer could not draw all of {file}: {error}", RuntimeWarning, stacklevel=2)


def _save(client: Any, shot: Path) -> None:
    """Save the picture of the whole window, with retries for a loaded machine. Raises RuntimeError if all fail."""
    for _ in range(TRIES):
        try:
            client.save_screenshot(str(shot))
        except TimeoutError:
            continue
        return
    raise RuntimeError("the viewer took too long to draw: the machine is busy, or its graphics driver too slow")


def check_recording(file: Path) -> None:
    """Raise ValueError if the file is not a recording: the viewer would only show nothing."""
    with file.open("rb") as opened:
        if opened.read(len(MAGIC)) != MAGIC:
            raise ValueError("the file is not a recording of the rerun viewer")


def view_errors(client: Any) -> list[str]:
    """Find what views could not draw, and why."""
    views = client.get_state().views
    return [f"{view.name}: {report.summary}" for view in views for report in view.reports if report.severity == "error"]


@contextlib.contextmanager
def headless_viewer(file: Path) -> Iterator[Any]:
    """A viewer without a window, as a client of `rerun.experimental`; it ends with the context."""
    from rerun.experimental import ViewerClient

    port = _free_port()
    with tempfile.TemporaryFile() as words:
        process = subprocess.Popen(
            [*_command(port), "--headless", "--window-size", SIZE, str(file)],
            stdout=subprocess.DEVNULL, stderr=words, start_new_session=True, preexec_fn=_die_with_parent,
        )  # fmt: skip
        try:
            yield _connected(process, ViewerClient, _url(port), words)
        except ConnectionError as error:  # a viewer that cannot draw may answer before it ends
            process.wait(PATIENCE)
            words.seek(0)
            raise RuntimeError(_last_words(words.read())) from error
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            process.wait()


def _die_with_parent() -> None:
    """Nobody would see a viewer without a window that outlives the program which looked through it."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)


def _command(port: int) -> list[str]:
    """The viewer's command line, bound to this machine: by default it listens to all of the network."""
    limits = ["--memory-limit", MEMORY, "--server-memory-limit", MEMORY]
    return [*_program(), "--bind", HOST, "--port", str(port), "--hide-welcome-screen", *limits]


def _program() -> list[str]:
    """The viewer that comes with the library, so that it has the version that wrote the recording."""
    spec = find_spec("rerun_cli")
    if spec is None or spec.origin is None:
        raise RuntimeError("the program rerun is not there; it comes with rerun-sdk")
    program = Path(spec.origin).with_name("rerun")
    return [str(program)] if program.exists() else [sys.executable, "-P", "-m", "rerun_cli"]


def _free_port() -> int:
    with socket.socket() as made:
        made.bind((HOST, 0))
        return int(made.getsockname()[1])


def _connected(process: subprocess.Popen[bytes], client: Any, url: str, words: Any) -> Any:
    """Return the client, as soon as the viewer answers."""
    until = monotonic() + PATIENCE
    while monotonic() < until:
        if process.poll() is not None:
            words.seek(0)
            raise RuntimeError(_last_words(words.read()))
        try:
            connected = client.connect(url)
            connected.get_state()
        except Exception:
            sleep(0.1)
        else:
            return connected
    raise RuntimeError(f"the viewer did not answer within {PATIENCE:.0f} s")


def _last_words(words: bytes) -> str:
    text = words.decode(errors="replace")
    if "render context" in text or "adapter" in text or "wgpu" in text.lower():
        return NO_DRIVER
    if "winit" in text.lower() or "display" in text.lower():
        return "the viewer found no display"
    lines = [line for line in text.splitlines() if line.strip()]
    return f"the viewer stopped: {lines[-1].strip()}" if lines else "the viewer stopped without a word"


def _wait_for(client: Any) -> None:
    """Wait until the recording is loaded and its views exist."""
    until = monotonic() + PATIENCE
    while monotonic() < until:
        state = client.get_state()
        if not state.loading and any(recording.timelines for recording in state.recordings) and state.views:
            return
        sleep(0.1)
    raise RuntimeError(f"the viewer did not load the recording within {PATIENCE:.0f} s")


def _ends(client: Any, name: str) -> tuple[int, int]:
    """First and last step, or iteration, of the recording."""
    for recording in client.get_state().recordings:
        for timeline in recording.timelines:
            if timeline.name == name:
                return int(timeline.start), int(timeline.end)
    raise ValueError(f"the recording has no {name}s")


def _publish(shot: Path, png: Path) -> None:
    """Write the picture with 256 colours: a fifth of the size. Those with a meaning are kept exactly."""
    from PIL import Image

    meant = [part for colour in dict.fromkeys((*(style.colour for style in STYLES), *STATES)) for part in rgb(colour)]
    with Image.open(shot) as image:
        shown = image.convert("RGB").crop((0, MENU, *image.size))
    count = 256 - len(meant) // 3
    found = shown.quantize(count, method=Image.Quantize.MEDIANCUT, kmeans=8).getpalette()
    palette = Image.new("P", (1, 1))
    palette.putpalette([*(found or [])[: 3 * count], *meant])
    shown.quantize(palette=palette, dither=Image.Dither.NONE).save(png, optimize=True)
