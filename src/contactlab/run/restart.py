"""Resuming an interrupted run where it was saved."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api.frame import Layout
from contactlab.errors import RequestError
from contactlab.results.files import write_contacts, write_summary
from contactlab.results.result_file import FILE, RESUMABLE
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import parse_toml

if TYPE_CHECKING:
    from contactlab.results.checkpoint_slots import Checkpoint


def finished_results(folder: Path, scene: Scene) -> Results | None:
    """The results in `folder` if there is nothing left to do, None if the run can be resumed or has not begun.

    Raises RequestError if the folder holds another scene, or a file that cannot be read.
    """
    saved = saved_run(folder)
    if saved is None:
        return None
    from contactlab.results.load import load_results

    refuse_other_scene(saved[0].layout.scene, scene, folder)
    results = load_results(folder)
    if results.status in RESUMABLE:
        return None
    try:
        written = bool(json.loads((folder / "summary.json").read_text(encoding="utf-8")) == results.summary)
    except (OSError, ValueError):
        written = False
    if not written:
        # it was killed between its last two files
        write_contacts(folder, {contact.name: results.contact[contact.name] for contact in results.layout.contacts})
        write_summary(folder, results.summary)
    return results


def saved_run(folder: Path) -> tuple[Results, Checkpoint] | None:
    """The run in `folder` up to its last checkpoint, None if there is no checkpoint."""
    if not (folder / FILE).is_file():
        return None
    from contactlab.results.load import load_checkpoint

    return load_checkpoint(folder)


def stored_results(folder: Path, otherwise: Results) -> Results:
    """The results as they were written; `otherwise` if the disk did not take them all."""
    from contactlab.results.load import load_results

    try:
        written = load_results(folder)
    except (RequestError, OSError):
        return otherwise
    return written if written.status == otherwise.status else otherwise


def differences_to(text: str, scene: Scene) -> list[str]:
    """Keys by which a stored scene differs from this one, with both values."""
    return _differences(parse_toml(text, "scene.toml"), scene.data)


def refuse_other_scene(text: str, scene: Scene, folder: Path) -> None:
    """Raise RequestError unless the stored scene is this scene: a run is resumed with the scene it began with."""
    if differences := differences_to(text, scene):
        raise RequestError(
            "the folder holds a run of another scene",
            where=f"results folder {folder}",
            got="; ".join(differences[:4]),
            hint=f"contactlab run {folder / 'scene.toml'} --out {folder} --resume, or another folder",
        )


def _differences(old: Any, new: Any, key: str = "") -> list[str]:
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        names = dict.fromkeys([*old, *new])
        return [d for n in names for d in _differences(old.get(n), new.get(n), f"{key}.{n}".strip("."))]
    if isinstance(old, list | tuple) and isinstance(new, list | tuple) and len(old) == len(new):
        return [d for i, (a, b) in enumerate(zip(old, new, strict=True)) for d in _differences(a, b, f"{key}.{i}")]
    return [] if old == new else [f"{key} was {old}, now {new}"]


def check_memory(saved: Mapping[str, np.ndarray], present: Mapping[str, np.ndarray], folder: Path) -> None:
    """Raise RequestError if the saved arrays do not fit the present model."""
    shapes = {name: array.shape for name, array in present.items()}
    for name, shape in shapes.items():
        if name not in saved or saved[name].shape != shape:
            raise RequestError(
                "the saved state does not fit the model of this scene",
                where=str(folder / FILE),
                got=f"{name} {saved[name].shape if name in saved else 'missing'}, needed {shape}",
                hint="use the versions that the run started with (see summary.json), or start again",
            )


def changed_versions(layout: Layout, present: Layout) -> list[str]:
    """Return versions that changed since the run began; results may then differ in their last digits."""
    names = dict.fromkeys([*layout.versions, *present.versions])
    return [
        f"{name} {layout.versions.get(name, 'absent')} is now {present.versions.get(name, 'absent')}"
        for name in names
        if layout.versions.get(name) != present.versions.get(name)
    ]
