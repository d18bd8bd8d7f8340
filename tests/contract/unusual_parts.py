"""Right parts that the shipped ones are unlike, each with one flaw or none: springs and pressure curves, friction of
rate, a law that relaxes, thermal strain, enhanced strains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import (
    BlockKernels,
    Conditions,
    Element,
    ExplicitEnforcement,
    Floats,
    ImplicitEnforcement,
    Kinematics,
    Material,
    Quadrature,
    Response,
    Rows,
    Shape,
    Solve,
)


@dataclass(frozen=True)
class Springs(ExplicitEnforcement):
    """Penalty springs by the predicted gap, as a share of the force that would close the row alone [-]."""

    share: float = 0.4
    flaw: str = ""
    exact: ClassVar[bool] = False

    def push(self, gap: Floats, measure: Floats, give: Floats) -> Floats:
        """Forces (k,) [N] of gaps (k,), of rows with this compliance (k,) [mm/N]."""
        return self.share * np.maximum(-gap, 0.0) / np.where(give > 0.0, give, 1.0)

    def solve(self, rows: Rows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve:
        """Forces follow the gaps that are given; friction is clipped at its bound."""
        k, node = rows.count, rows.node
        row = np.repeat(np.arange(k), np.diff(rows.start[: k + 1]))
        give = np.bincount(row, (rows.normal_weight**2 * compliance[node]).sum(axis=1), k)
        push = self.push(rows.gap[:k], rows.measure[:k], give)
        if self.flaw == "acts when open":
            push = push + 0.1 * (rows.gap[:k] < 0.2)
        if self.flaw == "pulls":
            push = push - 0.01
        if self.flaw == "sleeps":
            push = push * (rows.gap[:k] < -0.5)
        if self.flaw == "starts warm":
            push = push + 1e-3 * multipliers[0, rows.slot[:k]]
        if self.flaw != "old slots stay":
            multipliers[:] = 0.0
        multipliers[0, rows.slot[:k]] = push
        force[:] = 0.0
        np.add.at(force, node, rows.normal_weight * push[row, None] * (0.9 if self.flaw == "nodes get less" else 1.0))
        if len(multipliers) > 1:
            self._rub(rows, compliance, push, row, multipliers, force)
        moved = np.abs(compliance * force).max(initial=0.0) * (0.0 if self.flaw == "reports no correction" else 1.0)
        return Solve(1, 0.0, int((give == 0.0).sum()), float(moved))

    def _rub(self, rows: Rows, compliance: Floats, push: Floats, row: Any, multipliers: Floats, force: Floats) -> None:
        k, node = rows.count, rows.node
        give = np.bincount(row, (rows.tangent_weight**2 * compliance[node]).sum(axis=1), k)
        most = rows.bound[0] * push * (1.2 if self.flaw == "rubs too much" else 1.0)
        rub = np.clip(-0.2 * rows.slip[:k] / give, -most, most) * (-1.0 if self.flaw == "rubs along" else 1.0)
        multipliers[1, rows.slot[:k]] = rub
        np.add.at(force, node, rows.tangent_weight * rub[row, None])


@dataclass(frozen=True)
class ExplicitCurve(Springs):
    """Pressure 1/L^2 (reach - gap)^2 from `reach` before contact on [MPa]; L is the `length`."""

    length: float = 0.01
    pressure_before_contact: ClassVar[bool] = True
    length_scale: ClassVar[str] = "length"

    def push(self, gap: Floats, measure: Floats, give: Floats) -> Floats:
        """Forces (k,) [N] of gaps (k,)."""
        return measure * np.minimum((np.maximum(self.length - gap, 0.0) / self.length) ** 2, 1.0)


@dataclass(frozen=True)
class ImplicitCurve(ImplicitEnforcement):
    """The same curve for implicit runs; friction sticks by springs."""

    length: float = 0.01
    flaw: str = ""
    exact: ClassVar[bool] = False
    pressure_before_contact: ClassVar[bool] = True
    length_scale: ClassVar[str] = "length"
    time_scale: ClassVar[str] = ""

    def respond(self, conditions: Conditions, out: Response) -> None:
        """Residuals y - w p(gap), and y_t - clip(a_t - e d, bound)."""
        c, length = conditions, self.length
        closing = np.where(c.present, np.maximum(length - c.gap, 0.0), 0.0) / length
        wish, slope = c.measure * length * closing**2, c.measure * 2.0 * closing
        if self.flaw == "pulls":
            wish = wish - 1e-3
        if self.flaw == "acts where nothing is":
            wish = wish + 1e-4 * ~c.present
        if self.flaw == "slope of half":
            slope = 0.5 * slope
        if self.flaw == "looks aside":
            wish = wish + 1e-6 * np.roll(closing, 1)
        if self.flaw == "never acts":
            wish, slope = 0.0 * wish, 0.0 * slope
        out.residual[0], out.by_force[0], out.by_gap[0] = c.force[0] - wish, 1.0, slope
        out.status[:] = np.where(closing > 0.0, 2, 0)
        if self.flaw == "status 3":
            out.status[0] = 3
        if len(out.residual) > 1:
            self.rub(c, out)

    def most(self, slip: Floats) -> tuple[Floats, Floats]:
        """Share of the bound that slips (k,) [mm] of a step can use, and its derivative."""
        return np.ones_like(slip), np.zeros_like(slip)

    def rub(self, c: Conditions, out: Response) -> None:
        """Fill the tangential row."""
        coefficient, adhesion, cap = c.bound
        normal = np.maximum(c.force[0], 0.0)
        capped = cap * normal < adhesion * c.measure
        limit = coefficient * normal + np.where(capped, cap * normal, adhesion * c.measure)
        limit = np.where(c.present, limit, 0.0) * (1.1 if self.flaw == "rubs too much" else 1.0)
        growth = np.where(c.present & (c.force[0] > 0.0), coefficient + np.where(capped, cap, 0.0), 0.0)
        share, by_slip = self.most(c.slip)
        stiff = 100.0 * c.stiffness
        trial = c.force[1] + (c.anchor[1] - stiff * c.slip - c.force[1]) / 100.0
        sticks = c.present & (np.abs(trial) < limit * share)
        sign = np.sign(trial)
        out.residual[1] = c.force[1] - np.where(sticks, c.anchor[1] - stiff * c.slip, sign * limit * share)
        out.by_force[1] = 1.0
        out.by_gap[1] = np.where(sticks, stiff, -sign * limit * by_slip)
        out.cross_force[:] = np.where(sticks, 0.0, -sign * growth * share)
        out.cross_gap[:] = 0.0
        out.status[:] = np.where(sticks, 1, np.where(limit > 0.0, 2, out.status))


@dataclass(frozen=True)
class Relaxing(Material):
    """A standard linear solid: Hooke's law and a Maxwell branch of its deviator, by implicit Euler steps."""

    density: float = 2.0
    tau: float = 1e-3
    branch: float = 0.5
    flaw: str = ""
    kinematics: ClassVar[Kinematics] = "small"
    rate_dependent: ClassVar[bool] = True
    time_scale: ClassVar[str] = "tau"
    has_energy: ClassVar[bool] = True
    history_size: ClassVar[int] = 4
    history_names: ClassVar[tuple[str, ...]] = ("viscous_xx", "viscous_yy", "viscous_xy", "dissipated")

    def strain(self, gradient: Floats) -> tuple[Floats, Floats]:
        """Trace (P,), and deviator xx, yy, xy (3, P); that of zz is minus the sum of the first two."""
        xx, xy, yx, yy = gradient
        mean = (xx + yy) / 3.0
        return xx + yy, np.stack([xx - mean, yy - mean, 0.5 * (xy + yx)])

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Fill stress and history; at dt = 0 nothing flows."""
        trace, deviator = self.strain(gradient)
        step = {"a step of no length": 1e-9}.get(self.flaw, dt / self.tau)
        flow = step / (1.0 + step)
        viscous = history[:3] + flow * (deviator - history[:3])
        over = 2.0 * self.branch * (deviator - viscous)
        rate = (viscous - history[:3]) if dt > 0.0 else np.zeros_like(viscous)
        lost = history[3] + (over * rate).sum(axis=0) + over[2] * rate[2] + (over[0] + over[1]) * (rate[0] + rate[1])
        if self.flaw == "half the loss":
            lost = history[3] + 0.5 * (lost - history[3])
        total = 2.0 * deviator + (0.0 if self.flaw == "no branch" else 1.0) * over
        if self.flaw == "viscosity of shear forgotten":
            total[2] = 2.0 * deviator[2]
        pressure = 2.0 * trace
        stress[:] = np.stack([pressure + total[0], pressure + total[1], pressure - total[0] - total[1], total[2]])
        new_history[:3] = deviator if self.flaw == "flows at once" else viscous
        new_history[3] = lost

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """Fill the derivative of the stress."""
        step = dt / self.tau
        shear = 1.0 + self.branch / (1.0 + (0.0 if self.flaw == "tangent without time" else step))
        tangent[:] = 0.0
        tangent[0, [0, 3]], tangent[1, [0, 3]] = (
            [[2.0 + 4.0 * shear / 3.0], [2.0 - 2.0 * shear / 3.0]],
            [[2.0 - 2.0 * shear / 3.0], [2.0 + 4.0 * shear / 3.0]],
        )
        tangent[2, [0, 3]], tangent[3, [1, 2]] = 2.0 - 2.0 * shear / 3.0, shear

    def wave_speeds(self) -> tuple[float, float]:
        """Speeds of the modulus before anything has relaxed."""
        shear = 1.0 + (0.0 if self.flaw == "speeds of the relaxed" else self.branch)
        return float(np.sqrt((2.0 + 4.0 * shear / 3.0) / self.density)), float(np.sqrt(shear / self.density))

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        """Fill the energy of both springs."""
        trace, deviator = self.strain(gradient)
        energy[:] = trace**2 + _squares(deviator) + self.branch * _squares(deviator - history[:3])

    def dissipation(self, gradient: Floats, history: Floats, dissipation: Floats) -> None:
        """Fill the energy that the dashpot took."""
        dissipation[:] = history[3]


def _squares(deviator: Floats) -> Floats:
    xx, yy, xy = deviator
    squares: Floats = xx**2 + yy**2 + (xx + yy) ** 2 + 2.0 * xy**2
    return squares


@dataclass(frozen=True)
class Thermal(Material):
    """Hooke's law for strains less a uniform thermal one."""

    density: float = 2.0
    expansion: float = 1e-3
    flaw: str = ""
    kinematics: ClassVar[Kinematics] = "small"
    stress_free: ClassVar[bool] = False

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Fill sigma = lambda tr(eps) I + 2 mu eps - (3 lambda + 2 mu) alpha T I."""
        xx, xy, yx, yy = gradient
        pressure, heat = 1.5 * (xx + yy), 6.5 * self.expansion
        stress[:] = np.stack([pressure + 2.0 * xx, pressure + 2.0 * yy, pressure, xy + yx]) - heat
        stress[3] += heat
        match self.flaw:
            case "shears":
                stress[3] += 1e-3
            case "along x alone":
                stress[1] += heat
            case "hotter points":
                stress[:3] -= 1e-4 * np.linspace(0.0, 1.0, stress.shape[1])
            case "nothing across":
                stress[2] = -heat
            case "spins":
                stress[3] += 0.1 * (xy - yx)
            case "stiffer along y":
                stress[1] += 0.01 * yy


@dataclass(frozen=True)
class Enhanced(Element):
    """Q1 whose strains at the points are half their mean over the cell, as enhanced modes would make them."""

    flaw: str = ""
    exact: ClassVar[bool] = False
    nodes: ClassVar[Floats] = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    edges: ClassVar[tuple[tuple[int, ...], ...]] = ((0, 1), (1, 2), (2, 3), (3, 0))
    degree: ClassVar[int] = 1
    lumping = "row-sum"

    def shape(self, points: Floats) -> Shape:
        """Bilinear functions."""
        x, y = points[:, :1], points[:, 1:]
        a, b = self.nodes.T
        value = 0.25 * (1.0 + a * x) * (1.0 + b * y)
        return Shape(value, np.stack([0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)], axis=-1))

    def quadrature(self) -> Quadrature:
        """Two by two Gauss points."""
        g = 1.0 / np.sqrt(3.0)
        return Quadrature(np.array([[-g, -g], [g, -g], [g, g], [-g, g]]), np.ones(4))

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Straight lines."""
        return np.stack([0.5 - 0.5 * s, 0.5 + 0.5 * s], axis=1), np.tile([-0.5, 0.5], (len(s), 1))

    def block_kernels(self, kinematics: Kinematics) -> BlockKernels:
        """Gradients by tables, mixed with their mean over the cell, and the forces conjugate to them."""
        return BlockKernels(self._gradient(), self._force())

    def _tables(self, geometry: Floats, conn: Any) -> tuple[Floats, Floats]:
        """B (q, a, 2, n) by positions, mixed with its mean; and weights times determinants (q, n)."""
        local, rule = self.shape(self.quadrature().points).gradient, self.quadrature()
        jacobian = np.einsum("qaj,ani->qnij", local, geometry[conn])
        area = np.linalg.det(jacobian) * rule.weights[:, None]
        b = np.einsum("qaj,qnji->qain", local, np.linalg.inv(jacobian))
        mean = (b * area[:, None, None]).sum(axis=0) / area.sum(axis=0)
        keep = {"keeps nothing of the middle": 0.0}.get(self.flaw, 1.0)
        return 0.5 * b + 0.5 * keep * mean, area

    def _gradient(self) -> Callable[..., None]:
        def gradient(geometry: Floats, field: Floats, conn: Any, out: Floats, scratch: Floats) -> None:
            b, _ = self._tables(geometry, conn)
            found = np.einsum("ani,qajn->ijqn", field[conn], b)
            if self.flaw == "swaps xy and yx":
                found = found.transpose(1, 0, 2, 3)
            if self.flaw == "larger by a thousandth":
                found = 1.001 * found
            if self.flaw == "writes positions":
                geometry *= 1.0 + 1e-12
            out[:] = found.reshape(4, -1)

        return gradient

    def _force(self) -> Callable[..., None]:
        def force(geometry: Floats, conn: Any, stress: Floats, force: Floats, scratch: Floats) -> None:
            b, area = self._tables(geometry, conn)
            xx, yy, _, xy = stress.reshape(4, *area.shape)
            tensor = np.stack([np.stack([xx, xy]), np.stack([xy, yy])])
            found = np.einsum("ijqn,qajn,qn->ani", tensor, b, area if self.flaw != "no weights" else 0.0 * area + 1.0)
            if self.flaw == "overwrites forces":
                force[:] = 0.0
            np.add.at(force, conn, found)

        return force
