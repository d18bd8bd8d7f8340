"""A run's layout as part of `results.vtkhdf`."""

from __future__ import annotations

import json
from typing import Any

import h5py
import numpy as np

from contactlab.api.frame import BodyLayout, ContactLayout, Layout
from contactlab.results.checksums import sealed
from contactlab.results.stored_text import read_text, write_text

FORMAT = 4
"""Layout data in the group `contactlab` of `results.vtkhdf`."""

READ = (3, FORMAT)
"""Formats that are read; 3 has strings of variable length."""

_SURFACES = ("slave_nodes", "slave_segments", "master_nodes", "master_segments")


def write_layout(own: h5py.Group, layout: Layout) -> None:
    """Fill `scene`, `layout` (JSON), `nodes`, `bodies` and `contacts` of the group `contactlab`."""
    write_text(own, "scene", layout.scene)
    write_text(own, "layout", json.dumps(_words(layout)))
    own["nodes"] = layout.nodes
    for body in layout.bodies:
        own[f"bodies/{body.name}/cells"] = body.cells
    for contact in layout.contacts:
        for name in _SURFACES:
            own[f"contacts/{contact.name}/{name}"] = getattr(contact, name)


def _words(layout: Layout) -> dict[str, Any]:
    """Everything of a layout that is no array, as plain data."""
    bodies = [
        {"name": b.name, "element": b.element, "material": b.material, "internal_variables": b.internal_variables}
        for b in layout.bodies
    ]
    contacts = [
        {key: getattr(c, key) for key in ("name", "label", "algorithm", "slave", "master", "friction", "memory")}
        for c in layout.contacts
    ]
    return {
        "title": layout.title,
        "units": layout.units,
        "bodies": bodies,
        "contacts": contacts,
        "supports": layout.supports,
        "parts": dict(layout.parts),
        "versions": dict(layout.versions),
        "steps": layout.steps,
        "has_velocity": layout.has_velocity,
        "frames": layout.frames,
    }


def read_layout(own: h5py.Group) -> Layout:
    """The layout that `write_layout` wrote. Raises Damage."""
    words = json.loads(read_text(own, "layout"))
    bodies = tuple(
        BodyLayout(
            cells=sealed(own, f"bodies/{body['name']}/cells"),
            **{**body, "internal_variables": tuple(body["internal_variables"])},
        )
        for body in words.pop("bodies")
    )
    contacts = tuple(
        ContactLayout(
            **{**contact, "memory": tuple(contact.get("memory", ()))},
            **{name: sealed(own, f"contacts/{contact['name']}/{name}") for name in _SURFACES},
        )
        for contact in words.pop("contacts")
    )
    words.update({key: tuple(words[key]) for key in ("supports", "steps")})
    nodes: np.ndarray = sealed(own, "nodes")
    return Layout(scene=read_text(own, "scene"), nodes=nodes, bodies=bodies, contacts=contacts, **words)
