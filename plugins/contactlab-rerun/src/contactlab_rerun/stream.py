"""Streams of the library, and the threads that it leaves running behind them."""

from __future__ import annotations

import os
import threading
from pathlib import Path
from uuid import uuid4

import rerun as rr
import rerun.blueprint as rrb

APPLICATION = "contactlab"


PATIENCE = 60.0  # s that the library may take to let go of its end of a pipe


class FileStream:
    """A stream of the library that ends in a file.

    The library waits for ever if it cannot write (a quota, a limit of file size). So it writes into a pipe that is
    always read, and what reads it knows when the disk is full. Systems without pipes by name have the library write.
    """

    def __init__(self, path: Path) -> None:
        self.stream = rr.RecordingStream(APPLICATION, recording_id=uuid4(), send_properties=False)
        self.error: OSError | None = None
        self.reader: threading.Thread | None = None
        if not Path("/dev/fd").is_dir():
            self.stream.save(path, write_footer=False)
            return
        path.unlink(missing_ok=True)
        self.file = path.open("xb", buffering=0)
        self.source, self.end = os.pipe()
        self.reader = threading.Thread(target=self._read, name="contactlab-rerun", daemon=True)
        self.reader.start()
        self.stream.save(f"/dev/fd/{self.end}", write_footer=False)

    def _read(self) -> None:
        while data := os.read(self.source, 1 << 20):
            try:
                while data and self.error is None:
                    data = data[self.file.write(data) :]
            except OSError as error:
                self.error = error

    def close(self) -> None:
        """End the stream; `error` is the error of the disk."""
        self.stream.disconnect()
        if self.reader is not None:
            os.close(self.end)
            self.reader.join(PATIENCE)
            self.file.close()
            if not self.reader.is_alive():
                os.close(self.source)


def drop_streams() -> None:
    """End the threads and free the memory of all streams that are no longer in use.

    The library keeps every stream of a process, with two threads, until it is initialised again.
    """
    rr.init(APPLICATION, init_logging=False)


class Arrangement(rrb.Blueprint):
    """A blueprint that leaves no thread behind: the library sends it through a stream and never closes that one."""

    used: tuple[rr.RecordingStream, ...] = ()

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        self.used = (*self.used, stream)
        stream.set_log_time_enabled(False)
        super()._log_to_stream(stream)

    def send(self, recording: rr.RecordingStream) -> None:
        """Put it into a recording, as what the viewer shows and goes back to."""
        recording.send_blueprint(self, make_active=True, make_default=True)
        for stream in self.used:
            stream.disconnect()
        self.used = ()
