"""Fields at the end of a run, from its newest checkpoint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import BodyLayout, Layout
from contactlab.results.checkpoint_slots import Checkpoint
from contactlab.results.stored_frames import StoredFrames


class FinalFields:
    """Fields at the end of a run: from the newest checkpoint, which has them at every point."""

    def __init__(self, layout: Layout, checkpoint: Checkpoint | None, frames: StoredFrames) -> None:
        memory: Mapping[str, Floats] = checkpoint.memory if checkpoint is not None else {}
        last = frames[-1] if not memory and len(frames) else None
        self.displacement = (
            last.displacement if last else memory.get("state.displacement", np.zeros_like(layout.nodes)).copy()
        )
        self.velocity = last.velocity if last else memory.get("state.velocity", np.zeros((0, 2))).copy()
        self.stress = {body.name: _points(memory, "stress", body) for body in layout.bodies} if memory else {}
        self.internal_variables = {
            body.name: _variables(memory, body) for body in layout.bodies if body.internal_variables and memory
        }


def _blocks(memory: Mapping[str, Floats], what: str, body: BodyLayout) -> list[Floats]:
    found: list[Floats] = []
    while (name := f"{what}.{body.name}.{len(found)}") in memory:
        found.append(memory[name])
    return found


def _points(memory: Mapping[str, Floats], what: str, body: BodyLayout) -> Floats:
    """(n, q, components) from blocks (components, q B), point-major."""
    blocks = _blocks(memory, what, body)
    points = sum(block.shape[1] for block in blocks) // len(body.cells)
    return np.concatenate([b.reshape(len(b), points, -1).transpose(2, 1, 0) for b in blocks])


def _variables(memory: Mapping[str, Floats], body: BodyLayout) -> dict[str, Floats]:
    stress, flat = _blocks(memory, "stress", body), memory[f"state.history.{body.name}"].ravel()
    points = sum(block.shape[1] for block in stress) // len(body.cells)
    count, begin = len(flat) // (points * len(body.cells)), 0
    parts: list[Floats] = []
    for block in stress:
        size = count * block.shape[1]
        parts.append(flat[begin : begin + size].reshape(count, points, -1).transpose(2, 1, 0))
        begin += size
    values = np.concatenate(parts)
    return {name: values[:, :, i].copy() for i, name in enumerate(body.internal_variables)}
