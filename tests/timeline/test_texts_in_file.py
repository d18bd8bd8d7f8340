"""Texts in `results.vtkhdf` have a fixed length and a checksum; files of format 3, which had others, are still read."""

from __future__ import annotations

import json
import shutil
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from damages import everything
from stops import stopped_at

import contactlab
from contactlab.errors import RequestError
from contactlab.results.checksums import SEAL
from contactlab.results.results import Results
from contactlab.run.interruption import Interrupted
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
Assert = Callable[[Any, Any], None]
HEAP = b"GCOL"  # the signature of HDF5's heap of texts of variable length, which has no checksum


@pytest.fixture(scope="module")
def run(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A static run with frames, iterations, events (a warning), a checkpoint and a summary."""
    folder: Path = tmp_path_factory.mktemp("texts") / "run"
    statics = {"integrator": {"use": "newton", "steps": 3}, "time.end": 1.0, "supports.1.uy.to": -0.02}
    statics |= {"contacts.0.algorithm": "node-on-segment", "contacts.0.swap": True}
    results = simulate(small_scene(statics), folder)
    assert results.events
    assert results.iterations
    return folder


def test_a_file_has_no_heap_of_texts(run: Path, recorded: Results) -> None:
    assert recorded.folder is not None
    for folder in (run, recorded.folder):
        assert HEAP not in (folder / "results.vtkhdf").read_bytes()


@pytest.mark.parametrize("text", ["scene", "layout", "summary", "columns/history", "columns/checksums/frames"])
def test_a_changed_text_is_told(text: str, run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    with h5py.File(tmp_path / "run/results.vtkhdf", "r+") as file:
        dataset = file[f"contactlab/{text}"]
        bits = bytearray(dataset[()].tobytes())
        bits[len(bits) // 2] ^= 1
        dataset[...] = np.frombuffer(bytes(bits), dataset.dtype)
    with pytest.raises(RequestError, match="damaged"):
        everything(tmp_path / "run")


def test_files_of_format_3_are_read(run: Path, tmp_path: Path, assert_same_run: Assert) -> None:
    shutil.copytree(run, tmp_path / "old")
    as_format_3(tmp_path / "old/results.vtkhdf")
    assert HEAP in (tmp_path / "old/results.vtkhdf").read_bytes()
    new, old = contactlab.load_results(run), contactlab.load_results(tmp_path / "old")
    assert_same_run(new, old)
    assert new.events == old.events
    assert new.summary == old.summary


@pytest.mark.full
def test_a_run_of_format_3_is_taken_up(small_scene: MakeScene, tmp_path: Path, assert_same_run: Assert) -> None:
    scene = small_scene({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}})
    whole = simulate(scene, tmp_path / "whole")
    with stopped_at(100), pytest.raises(Interrupted):
        simulate(scene, tmp_path / "old")
    as_format_3(tmp_path / "old/results.vtkhdf")
    resumed = simulate(scene, tmp_path / "old", resume=True)
    assert_same_run(whole, resumed)
    assert resumed.events[: len(whole.events)] == whole.events
    assert contactlab.load_results(tmp_path / "old").events == resumed.events


def as_format_3(path: Path) -> None:
    """Put the texts of a file where format 3 had them."""
    with h5py.File(path, "r+") as file:
        own = file["contactlab"]
        own.attrs["format"] = np.int64(3)
        for name in ("scene", "layout", "summary"):
            if name not in own:
                continue
            text = own[name][()].tobytes().decode()
            kept: dict[str, Any] = {key: value for key, value in own[name].attrs.items() if key != SEAL}
            del own[name]
            own[name] = text
            own[name].attrs[SEAL] = np.uint32(zlib.crc32(text.encode()))
            for key, value in kept.items():
                own[name].attrs[key] = value
        own["checkpoint"].attrs["arrays"] = own["checkpoint/arrays"][()].tobytes().decode()
        del own["checkpoint/arrays"]
        columns = {
            "history": ("history", "columns"),
            "checksums/frames": ("checksums/frames", "names"),
            "steps": ("steps", "columns"),
            "iterations/rows": ("iterations/rows", "columns"),
        }
        for table, (dataset, attribute) in columns.items():
            if dataset not in own:
                continue
            own[dataset].attrs[attribute] = [name.decode() for name in own[f"columns/{table}"]]
        del own["columns"]
        events = own["events"]
        words, ends = events["words"][:].tobytes(), events["end"][:].tolist()
        texts = [words[begin:end].decode() for begin, end in zip([0, *ends], ends, strict=False)]
        events.create_dataset("text", data=texts, maxshape=(None,), dtype=h5py.string_dtype(), chunks=(64,))
        del events["words"], events["end"]
        assert json.loads(own["layout"][()])
