"""Edge sets by name, as scenes write them: "body.set"."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Ints
from contactlab.errors import SceneError, did_you_mean
from contactlab.model.body import Body


def edge_set(bodies: tuple[Body, ...], name: str, where: Any) -> tuple[Body, Ints]:
    """The edges (e, b) named "body.set", in global node numbers."""
    body_name, _, set_name = name.partition(".")
    by_name = {body.name: body for body in bodies}
    if body_name not in by_name:
        raise SceneError(
            "no such body", where=where, got=name, allowed=", ".join(by_name), hint=did_you_mean(body_name, by_name)
        )
    body = by_name[body_name]
    sets = body.mesh.edges
    if set_name not in sets:
        names = [f"{body_name}.{key}" for key in sets]
        raise SceneError(
            "no such edge set", where=where, got=name, allowed=", ".join(names), hint=did_you_mean(name, names)
        )
    if not len(sets[set_name]):
        raise SceneError("the edge set is empty", where=where, got=name, hint="name another one, or mend the mesh")
    return body, (sets[set_name] + body.first).astype(np.int32)
