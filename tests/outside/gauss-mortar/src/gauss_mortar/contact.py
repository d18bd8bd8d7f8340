"""Mortar contact by Gauss points: piecewise-linear multipliers, in plain NumPy."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ContactAlgorithm


def cross(u, v):
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


@dataclass(frozen=True)
class GaussMortar(ContactAlgorithm):
    """Linear multipliers on the slave, integrated at Gauss points of its segments.

    points  Gauss points per slave segment
    """

    points: int = 4
    passes_patch_test: ClassVar[bool] = False  # points miss the kinks of the master's functions

    def __post_init__(self):
        if not 2 <= self.points <= 16:
            raise ValueError(f"points: got {self.points}, allowed: 2 to 16")

    def widths(self, slave, master):
        return 2, 2, 2  # a point couples both ends of a slave segment and of a master segment

    def capacity(self, slave, near):
        return self.points * len(slave.segments)

    def pieces(self, view, out):
        slave, master, at, near, reach, _ = view
        xi, weight = np.polynomial.legendre.leggauss(self.points)
        hats = np.stack([1.0 - xi, 1.0 + xi], axis=1) / 2.0
        ends = at.slave[slave.segments]
        along = ends[:, 1] - ends[:, 0]
        length = np.hypot(along[:, 0], along[:, 1])
        inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None]  # away from the master
        out.normal[:] = 0.0
        np.add.at(out.normal, slave.segments, (length[:, None] * inward)[:, None])
        out.normal /= np.hypot(out.normal[:, 0], out.normal[:, 1])[:, None]

        # every point (g) of a slave segment against every master segment near it (z): x = a + t edge + gap normal
        owner = np.repeat(np.arange(len(ends)), np.diff(near.start))
        edges = at.master[master.segments[near.master]]
        edge, normal = (edges[:, 1] - edges[:, 0])[:, None], inward[owner][:, None]
        offset = np.einsum("ge,zei->zgi", hats, ends[owner]) - edges[:, :1]
        facing = cross(edge, normal)  # negative where the sides face each other
        with np.errstate(divide="ignore", invalid="ignore"):
            t, gap = cross(offset, normal) / facing, cross(edge, offset) / facing
        hit = (facing < -0.5 * np.hypot(edge[..., 0], edge[..., 1])) & (t >= 0.0) & (t <= 1.0) & (abs(gap) <= reach)
        z, g = np.nonzero(hit)
        order = np.argsort(abs(gap[z, g]))
        first = np.unique((owner[z] * self.points + g)[order], return_index=True)[1]  # the nearest of each point
        z, g, count = z[order][first], g[order][first], len(first)

        out.slave[:count] = out.multiplier[:count] = slave.segments[owner[z]]
        out.master[:count] = master.segments[near.master[z]]
        basis = (weight[g] * length[owner[z]] / 2.0)[:, None, None] * hats[g][:, None, :]
        out.D[:count] = out.T[:count] = hats[g][:, :, None] * basis
        out.M[:count] = np.stack([1.0 - t[z, g], t[z, g]], axis=1)[:, :, None] * basis
        return count
