"""Velocities at the end of a step: closed surfaces neither separate nor approach.

A gap that multipliers or stiff springs hold at the end of a step says nothing about velocities there: the midpoint rule
would let them oscillate about the right ones for ever. Impulses z with

    v = v* + M^-1 (G^T z + T^T C z),   G v = 0

over all closed constraints G (and the tangential rows of constraints in stick) are the projection of v* in the metric
kinetic energy, which can only fall without friction: 1/2 z . G (v* + v) = -1/2 z . G M^-1 G^T z. Surfaces that slip
(tangential rows T) have friction C z in addition to a normal impulse, C = -mu times the sense of the slip: in the step
when surfaces meet the midpoint rule needs twice the force that stops them; z removes half of it, and friction with it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, ImplicitContact, Response
from contactlab.api.frame import STICK
from contactlab.implicit.sparse import combined, diagonal, picked, product, scaled, stacked, total, transposed


class Impulses(NamedTuple):
    """Impulses [N s] on the nodes (N, 2) and in each constraint (r, k), and their works [mJ].

    Prescribed motion of other nodes counts as well. `lost` is the work of normal impulses and of impulses in stick,
    `rubbed` the work of friction on surfaces that slip.
    """

    nodal: Floats
    each: Floats
    lost: float
    rubbed: float


def solve_impulses(contact: ImplicitContact, response: Response, mobility: Floats, velocity: Floats) -> Impulses:
    """Change `velocity` (N, 2) in place by the impulses after which closed contacts do not close further.

    `mobility` (N, 2) is the inverse mass. Springs that are softer than their nodes, with the inertia
    over the step, stop surfaces gradually and return the stored energy; stiffer springs hold gaps like multipliers.
    """
    force, enforcement = contact.conditions.force, contact.enforcement
    closed = contact.conditions.present & (force[0] > 0.0)
    if not (enforcement.exact or enforcement.augments):
        nodes = np.where(closed, contact.conditions.stiffness, 0.0)
        closed &= response.by_force[0] * nodes <= response.by_gap[0]
    if not closed.any():
        return Impulses(np.zeros_like(velocity), np.zeros_like(force), 0.0, 0.0)
    normal, tangent = contact.directions(np.flatnonzero(closed).astype(np.int32))
    stick, ratio = np.zeros(0, np.int64), np.zeros(0)
    if len(force) > 1:
        stick = np.flatnonzero(response.status[closed] == STICK)
        ratio = np.where(response.status[closed] == STICK, 0.0, np.sign(force[1, closed]))
        ratio *= contact.conditions.bound[0, closed]
    sticking = [picked(tangent, stick)] if len(stick) else []
    rubbing = scaled(tangent, ratio) if ratio.any() else scaled(normal, np.zeros(normal.shape[0]))
    held, acting = stacked([normal, *sticking]), stacked([total(normal, rubbing), *sticking])
    speed, sliding = held @ velocity.reshape(-1), rubbing @ velocity.reshape(-1)
    flexible = product(product(held, diagonal(mobility.reshape(-1))), transposed(acting))
    # redundant constraints share their impulse
    impulse = -np.linalg.lstsq(flexible.toarray(), speed, rcond=1e-12)[0]
    each, count = np.zeros_like(force), normal.shape[0]
    each[0, closed] = impulse[:count]
    if len(force) > 1:
        each[1, closed] = ratio * impulse[:count]
        each[1, np.flatnonzero(closed)[stick]] = impulse[count:]
    nodal = combined(acting, impulse).reshape(velocity.shape)
    velocity += mobility * nodal
    lost = 0.5 * float(impulse @ (speed + held @ velocity.reshape(-1)))
    rubbed = 0.5 * float(impulse[:count] @ (sliding + rubbing @ velocity.reshape(-1)))
    return Impulses(nodal, each, lost, rubbed)
