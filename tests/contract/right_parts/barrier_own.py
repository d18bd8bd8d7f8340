# kind contact cls Barrier
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Potential


@dataclass(frozen=True)
class Barrier(Potential):
    """Slave nodes and master nodes have the energy -k w/D (D - d)^2 ln(d/D) at a distance d below D.

    reach  D [mm], distance at which it begins
    k      [MPa]
    """

    reach: float = 0.05
    k: float = 100.0
    passes_patch_test: ClassVar[bool] = False

    def clearance(self, view):
        return self.reach

    def _pairs(self, view, x):
        m, s = len(view.slave.nodes), len(view.slave.segments)
        for nodes, edges in ((np.arange(m), view.edges[s:]), (np.arange(m, len(x)), view.edges[:s])):
            a, b = x[edges[:, 0]], x[edges[:, 1]]
            edge = b - a
            t = np.einsum("nei,ei->ne", x[nodes][:, None] - a, edge) / (edge**2).sum(axis=1)
            t = np.clip(t, 0.0, 1.0)
            away = x[nodes][:, None] - a - t[..., None] * edge
            d = np.hypot(away[..., 0], away[..., 1])
            near = d.argmin(axis=1)
            k = np.arange(len(nodes))
            yield nodes, edges[near], t[k, near], away[k, near], d[k, near]

    def energy(self, view, positions):
        total = 0.0
        for nodes, _, _, _, d in self._pairs(view, positions):
            close = d < self.reach
            if (d[close] <= 0.0).any():
                return float("inf")
            strength, d = view.length[nodes][close] * self.k / self.reach, d[close]
            total -= float((strength * (self.reach - d) ** 2 * np.log(d / self.reach)).sum())
        return total

    def gradient(self, view, positions):
        out = np.zeros_like(positions)
        for nodes, edges, t, away, d in self._pairs(view, positions):
            close = d < self.reach
            n, e, t, away, d = nodes[close], edges[close], t[close], away[close], d[close]
            gap = self.reach - d
            slope = view.length[n] * self.k / self.reach * (2.0 * gap * np.log(d / self.reach) - gap**2 / d)
            force = (slope / d)[:, None] * away
            np.add.at(out, n, force)
            np.add.at(out, e[:, 0], -(1.0 - t)[:, None] * force)
            np.add.at(out, e[:, 1], -t[:, None] * force)
        return out

    def largest_step(self, view, positions, displacement):
        share = 1.0
        m, s = len(view.slave.nodes), len(view.slave.segments)
        for nodes, edges in ((np.arange(m), view.edges[s:]), (np.arange(m, len(positions)), view.edges[:s])):
            speed = (
                displacement[nodes, None] - displacement[edges[:, 0]],
                displacement[nodes, None] - displacement[edges[:, 1]],
            )
            speed = np.maximum(*(np.hypot(v[..., 0], v[..., 1]) for v in speed))
            first, t = None, 0.0
            for _ in range(2000):
                x = positions + t * displacement
                a, edge = x[edges[:, 0]], x[edges[:, 1]] - x[edges[:, 0]]
                along = np.clip(np.einsum("nei,ei->ne", x[nodes][:, None] - a, edge) / (edge**2).sum(axis=1), 0.0, 1.0)
                away = x[nodes][:, None] - a - along[..., None] * edge
                d = np.hypot(away[..., 0], away[..., 1])
                first = d if first is None else first
                step = ((d - 0.1 * first) / np.where(speed > 0.0, speed, 1e-300)).min()
                if step < 1e-6 or t >= share:
                    break
                t += 0.9 * step
            share = min(share, t)
        return share
