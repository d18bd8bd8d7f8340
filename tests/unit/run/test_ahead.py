"""Kernels that other processes compile ahead: the right ones, once, and none where all is in the cache."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from contactlab.api.compiled.locks import free_place, kernel_locked, lock_file
from contactlab.jobs.perform import warm_up
from contactlab.run import ahead
from contactlab.run.compile_listed import signature
from contactlab.run.known_kernels import kernels_of, surely_called
from contactlab.scene.scene import bundled_scenes, load_scene

KERNELS = """
from contactlab.api.compiled.kernel import kernel

@kernel
def doubled(n, values):
    for i in range(n):
        values[i] *= 2.0

@kernel
def halved(n, values):
    for i in range(n):
        values[i] *= 0.5
"""
PROGRAM = """
import json, sys
import numpy as np
from contactlab.run import ahead
from contactlab.run.compile_listed import signature
from contactlab.run.known_kernels import KnownKernel
from importlib import import_module

wanted = [KnownKernel("some_package.kernels", name, "i8, f8[::1]", 1.0) for name in ("doubled", "halved")]
missing = [kernel.name for kernel in wanted if ahead._is_missing(kernel)]
ahead.usable_cores = lambda: 2
ahead._start(wanted, 1)
ahead.wait_for_all()
module, values = import_module("some_package.kernels"), np.ones(3)
module.doubled(3, values)
module.halved(2, values)
hits = [sum(getattr(module, name).stats.cache_hits.values()) for name in ("doubled", "halved")]
left = [kernel.name for kernel in wanted if ahead._is_missing(kernel)]
print(json.dumps([missing, hits, left, values.tolist()]))
"""


@pytest.mark.full
def test_what_was_compiled_ahead_is_loaded(tmp_path: Path) -> None:
    (tmp_path / "some_package").mkdir()
    (tmp_path / "some_package" / "__init__.py").write_text("")
    (tmp_path / "some_package" / "kernels.py").write_text(KERNELS)
    env = {**os.environ, "CONTACTLAB_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", PROGRAM], env=env, capture_output=True, text=True, check=True)
    missing, hits, left, values = json.loads(done.stdout)
    assert missing == ["doubled", "halved"]
    assert hits == [1, 1]
    assert left == []
    assert values == [1.0, 1.0, 2.0]


@pytest.mark.parametrize("changes", [{}, {"integrator": "newton"}, {"contacts.0.algorithm": "node-on-segment"}])
def test_types_are_those_of_calls(changes: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """And nothing is started where nothing is missing."""
    scene = load_scene("disc-on-block").with_(changes)
    warm_up(scene, lambda line: None)
    known = [kernel for kernel in kernels_of(scene) if kernel.types]
    assert len(known) >= 5
    for module, name, types, seconds in known:
        assert seconds > 0.0
        assert signature(types) in getattr(import_module(module), name).signatures, name
    started: list[object] = []
    monkeypatch.setattr(ahead, "_start", lambda *arguments: started.append(arguments))
    ahead._compile.cache_clear()
    ahead.compile_ahead(scene)
    assert not started
    monkeypatch.setattr(ahead, "_is_missing", lambda kernel: True)
    ahead._compile.cache_clear()
    ahead.compile_ahead(scene)
    (kernels, _), *_ = started  # type: ignore[misc]
    assert [kernel.seconds for kernel in kernels] == sorted((kernel.seconds for kernel in known), reverse=True)
    ahead._compile.cache_clear()


def test_nothing_is_compiled_for_parts_that_a_scene_has_not() -> None:
    scene = load_scene("disc-on-block")
    assert surely_called(scene) == kernels_of(scene)
    assert surely_called(scene.with_({"contacts": []})) == ()


@pytest.mark.parametrize("name", list(bundled_scenes()))
def test_known_kernels_are_there(name: str) -> None:
    for module, kernel, *_ in kernels_of(load_scene(name)):
        assert callable(getattr(import_module(module), kernel))


def test_a_kernel_that_another_process_has_in_hand_is_waited_for_or_left(tmp_path: Path) -> None:
    from contactlab.kernels.contact.search import boxes

    path = lock_file(boxes)
    assert path is not None
    hold = f"import fcntl, sys; f = open({str(path)!r}, 'a'); fcntl.flock(f, 2); print(1, flush=True); sys.stdin.read()"
    path.parent.mkdir(parents=True, exist_ok=True)
    with subprocess.Popen([sys.executable, "-c", hold], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdin is not None
        other.stdout.readline()
        with kernel_locked(boxes, wait=False) as free:
            assert not free
        other.stdin.close()
        with kernel_locked(boxes) as free:  # given back by the end of the process
            assert free
            with kernel_locked(boxes, wait=False) as inner:
                assert inner


def test_places_are_shared_and_given_back(tmp_path: Path) -> None:
    first, second = free_place(tmp_path, 2), free_place(tmp_path, 2)
    assert first is not None
    assert second is not None
    assert free_place(tmp_path, 2) is None
    first.close()
    third = free_place(tmp_path, 2)
    assert third is not None
    for file in (second, third):
        file.close()
    assert free_place(tmp_path, 0) is None
