"""From a model to what recorders see of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api.arrays import XX, XY, YY, ZZ, Floats
from contactlab.api.frame import BodyLayout, ContactLayout, Frame, Layout
from contactlab.model.bodies.body import Block, BodyForces
from contactlab.model.model import Model
from contactlab.results.sample import Sample
from contactlab.results.step_columns import step_columns
from contactlab.scene.keys import Contact
from contactlab.scene.scene import Scene

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair


def layout_of(model: Model, scene: Scene, parts: Mapping[str, str], versions: Mapping[str, str]) -> Layout:
    """Everything that stays the same during a run: bodies, contacts, parts, versions."""
    pairs = model.contact.pairs if model.contact is not None else ()
    supports = tuple(support.on for support in model.loading.supports)
    return Layout(
        scene=scene.toml(),
        title=scene.name,
        units=scene.units,
        nodes=model.reference.copy(),
        bodies=tuple(
            BodyLayout(
                body.name,
                scene.bodies[body.name].element["use"],
                scene.materials[scene.bodies[body.name].material]["use"],
                body.cells,
                body.material.history_names,
            )
            for body in model.bodies
        ),
        contacts=tuple(_contact(pair, spec) for pair, spec in zip(pairs, scene.contacts, strict=True)),
        supports=supports,
        parts=parts,
        versions=versions,
        steps=step_columns(supports, [pair.name for pair in pairs], model.split is not None),
        has_velocity="velocity" in model.state,
        frames=scene.record.frames,
    )


def _contact(pair: ContactPair, spec: Contact) -> ContactLayout:
    slave, master = spec.sides
    return ContactLayout(
        name=pair.name,
        label=spec.name or pair.name,
        algorithm=spec.algorithm["use"],
        slave=slave,
        master=master,
        friction=spec.friction["use"] if spec.friction else "",
        slave_nodes=pair.slave.nodes,
        slave_segments=pair.slave.segments,
        master_nodes=pair.master.nodes,
        master_segments=pair.master.segments,
        memory=tuple(pair.memory),
    )


def frame_of(model: Model, sample: Sample) -> Frame:
    """The sample with all fields of the model's present state."""
    state = model.state
    return Frame(
        number=sample.number,
        step=sample.step,
        time=sample.time,
        scalars=sample.scalars(),
        curves={name: report.curve for name, report in sample.contacts.items()},
        displacement=state["displacement"].copy(),
        velocity=state["velocity"].copy() if "velocity" in state else np.zeros((0, 2)),
        cells={forces.body.name: _cells(forces) for forces in model.forces},
    )


def _cells(forces: BodyForces) -> dict[str, Floats]:
    """Take means over the points of each cell."""
    points, names = forces.body.points, forces.body.material.history_names
    shown = [i for i, name in enumerate(names) if not name.startswith("stress_")]
    stress = [_mean(block.stress, points).T for block in forces.current()]
    mises = [_mean(von_mises(block), points) for block in forces.current()]
    fields = {"stress": np.concatenate(stress), "von_mises": np.concatenate(mises)}
    for i in shown:
        fields[names[i]] = np.concatenate([_mean(block.history[i], points) for block in forces.blocks])
    return fields


def _mean(values: Floats, points: int) -> Floats:
    """Mean over points of (..., q B), point-major."""
    return np.asarray(values.reshape(*values.shape[:-1], points, -1).mean(axis=-2))


def von_mises(block: Block) -> Floats:
    """Von Mises stress [MPa] at every point (P,) of a block."""
    s = block.stress
    deviator = (s[XX] - s[YY]) ** 2 + (s[YY] - s[ZZ]) ** 2 + (s[ZZ] - s[XX]) ** 2
    return np.asarray(np.sqrt(0.5 * deviator + 3.0 * s[XY] ** 2))
