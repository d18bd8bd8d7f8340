"""`reference = "finest"`: the pressure of a scene on meshes twice as fine as the finest compared, with its error."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contactlab.api import Potential
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.combination import combination_plan
from contactlab.studies.gather import gather
from contactlab.studies.make_reference import holds_for, mean_curve, reference_files
from contactlab.studies.plan import make_plan
from contactlab.studies.profile import distance, norm
from contactlab.studies.reference import Reference, load_reference
from contactlab.studies.study import FINEST
from contactlab.studies.table import Row, Table

ALGORITHMS = 2
"""Number of algorithms in the mean of a reference: the algorithms that change least between levels."""


@dataclass(frozen=True)
class Finest:
    """References of the scenes of a study, by what their answers depend on; `why` other scenes have no reference."""

    found: Mapping[str, Reference]
    why: Mapping[str, str] = field(default_factory=dict)
    name: str = FINEST

    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Return why there is no reference of this scene; empty if there is one."""
        place = answer_key(scene)
        return "" if place in self.found else self.why.get(place, "no finer run of this scene was made")

    def at(self, scene: Mapping[str, Any]) -> Reference:
        """The reference of the scene."""
        return self.found[answer_key(scene)]


def answer_key(scene: Mapping[str, Any]) -> str:
    """Hash of what the quasi-static answer of a scene depends on: not its mesh, algorithms or integrator."""
    return hashlib.sha256(json.dumps(holds_for(scene), sort_keys=True, default=str).encode()).hexdigest()[:12]


def finest_plan(
    scenes: Sequence[Scene], contact: int, folder: Path | None
) -> Generator[Sequence[Any], Sequence[Any], Finest]:
    """References for these scenes: for each different answer runs at the finest level among them and at twice that.

    They are written into `folder`, if there is one; what is there already serves again.
    """
    groups: dict[str, list[Scene]] = {}
    for scene in scenes:
        groups.setdefault(answer_key(scene.data), []).append(scene)
    with TemporaryDirectory() as passing:
        place = Path(passing) if folder is None else folder / FINEST
        answers = yield [_answer_plan(max(g, key=lambda s: s.level), contact, place / k) for k, g in groups.items()]
    known = dict(zip(groups, answers, strict=True))
    found = {key: replace(one, name=FINEST) for key, one in known.items() if isinstance(one, Reference)}
    return Finest(found, {key: one for key, one in known.items() if isinstance(one, str)})


def _answer_plan(scene: Scene, contact: int, folder: Path) -> Generator[Sequence[Any], Sequence[Any], Reference | str]:
    """The reference of one scene, or why it does not exist."""
    if (folder / f"{FINEST}.json").is_file():
        return load_reference(str(folder / f"{FINEST}.json"))
    levels = (scene.level, 2 * scene.level)
    algorithms = tuple(with_multipliers(scene.registry))
    plan = make_plan(scene, {f"contacts.{contact}.algorithm": algorithms, "level": levels})
    done = yield [combination_plan(one, 1) for one in plan.jobs]
    rows = gather(plan, {one.name: record for one, record in zip(plan.jobs, done, strict=True)}, None)
    table = Table(rows, plan.study, None, plan.scene.data)
    kept = steadiest(table, levels)
    if not kept:
        ends = "; ".join(f"{row.algorithm}: {row.status}" for row in table.rows if row.level == levels[-1])
        return f"no run at level {levels[-1]} has a pressure at its end ({ends}), so there is no finest run"
    chosen = replace(table, rows=kept, study=replace(table.study, name=f"{scene.name}, from finer meshes"))
    origin = f"Runs at levels {levels[0]} and {levels[1]}: {', '.join(dict.fromkeys(row.algorithm for row in kept))}."
    return load_reference(str(reference_files(FINEST, chosen, levels, mean_curve(chosen, levels), folder, origin)))


def with_multipliers(registry: Registry) -> list[str]:
    """Algorithms that pass the patch test and hold surfaces apart exactly, so that meshes alone make their errors."""
    names = registry.names("contact")
    kinds = {name: registry.part_class("contact", name) for name in names}
    exact = [name for name in names if kinds[name].passes_patch_test and not issubclass(kinds[name], Potential)]
    return exact or names


def steadiest(table: Table, levels: Sequence[int]) -> list[Row]:
    """Rows of the algorithms that came to their end at both levels and change least between them."""
    pairs: dict[str, dict[int, Row]] = {}
    for row in table.rows:
        if row.finished and row.profile is not None and norm(row.profile) > 0.0:
            pairs.setdefault(row.algorithm, {})[row.level] = row
    whole = [pair for pair in pairs.values() if len(pair) == len(levels)]
    whole.sort(key=lambda pair: _change(pair[levels[0]], pair[levels[-1]]))
    return [row for pair in whole[:ALGORITHMS] for row in pair.values()]


def _change(coarse: Row, fine: Row) -> float:
    assert coarse.profile is not None
    assert fine.profile is not None
    return distance(coarse.profile, fine.profile) / norm(fine.profile)
