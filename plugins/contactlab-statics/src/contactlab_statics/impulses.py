"""Velocities at the end of a step: closed surfaces part or meet no more.

A gap that is held at zero at the end of a step says nothing about velocities there: the midpoint rule would let
them swing about the right ones for ever. Impulses z with

    v = v* + M^-1 G^T z,   G v = 0

over all closed conditions G (and the tangential ones of those that stick) are the projection of v* in the metric of
kinetic energy, which can only fall: 1/2 z . G (v* + v) = -1/2 z . G M^-1 G^T z.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import diags_array, vstack

from contactlab.api import Floats, ImplicitContact, Response

STICK = 1


def solve_impulses(
    contact: ImplicitContact, response: Response, mobility: Floats, velocity: Floats
) -> tuple[Floats, Floats, float]:
    """Change `velocity` (N, 2) in place by the least impulses after which closed contacts do not close further.

    Returns normal impulses and those of sticking (N, 2) [N s] on the nodes, and the work that all of them do on the
    nodes and on what moves others by prescription: the energy lost, <= 0. `mobility` (N, 2) is the inverse mass.
    """
    force = contact.conditions.force
    closed = contact.conditions.present & (force[0] > 0.0)
    stick = closed & (response.status == STICK) if len(force) > 1 else np.zeros_like(closed)
    none = np.zeros_like(velocity)
    if not closed.any():
        return none, none, 0.0
    rows, count = _directions(contact, np.flatnonzero(closed), np.flatnonzero(stick))
    flexible = rows @ diags_array(mobility.reshape(-1)) @ rows.T
    speed = rows @ velocity.reshape(-1)
    # conditions that hold the same motion twice share their impulse
    impulse = -np.linalg.lstsq(flexible.toarray(), speed, rcond=1e-12)[0]
    normal = np.asarray(rows[:count].T @ impulse[:count]).reshape(velocity.shape)
    tangential = np.asarray(rows[count:].T @ impulse[count:]).reshape(velocity.shape)
    velocity += mobility * (normal + tangential)
    return normal, tangential, 0.5 * float(impulse @ (speed + rows @ velocity.reshape(-1)))


def _directions(contact: ImplicitContact, closed: Any, stick: Any) -> tuple[Any, int]:
    """Rows of G (c, 2N): normal ones, then `count` onwards those of sticking."""
    normal, tangent = contact.directions(closed.astype(np.int32))
    rows = [normal]
    if len(stick):
        rows.append(tangent[np.searchsorted(closed, stick)])
    return vstack(rows, format="csr"), len(closed)
