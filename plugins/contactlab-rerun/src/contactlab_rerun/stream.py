"""Streams of the library, and the threads that it leaves running behind them."""

from __future__ import annotations

from pathlib import Path
from uuid import uuid4

import rerun as rr
import rerun.blueprint as rrb

APPLICATION = "contactlab"


def stream_to(file: Path) -> rr.RecordingStream:
    """Open a stream that writes into a file of its own."""
    stream = rr.RecordingStream(APPLICATION, recording_id=uuid4())
    stream.save(file)
    return stream


def drop_streams() -> None:
    """End the threads and free the memory of all streams that nobody holds any more.

    The library keeps every stream of a process, with two threads, until it is told to begin anew.
    """
    rr.init(APPLICATION, init_logging=False)


class Arrangement(rrb.Blueprint):
    """A blueprint that leaves no thread behind: the library sends it through a stream and never closes that one."""

    used: tuple[rr.RecordingStream, ...] = ()

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        self.used = (*self.used, stream)
        super()._log_to_stream(stream)

    def send(self, recording: rr.RecordingStream) -> None:
        """Put it into a recording, as what the viewer shows and goes back to."""
        recording.send_blueprint(self, make_active=True, make_default=True)
        for stream in self.used:
            stream.disconnect()
        self.used = ()
