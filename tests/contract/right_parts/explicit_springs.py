# kind enforcement cls Springs
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ExplicitEnforcement, Solve


@dataclass(frozen=True)
class Springs(ExplicitEnforcement):
    """Penalty springs of the predicted gap, as a share of what would close a row alone.

    share  [-]
    """

    share: float = 0.4
    exact: ClassVar[bool] = False

    def solve(self, rows, compliance, multipliers, force):
        k = rows.count
        z = rows.start[k]
        node = rows.node[:z]
        row = np.repeat(np.arange(k), np.diff(rows.start[: k + 1]))
        give = np.bincount(row, (rows.normal_weight[:z] ** 2 * compliance[node]).sum(axis=1), k)
        safe = np.where(give > 0.0, give, 1.0)
        push = np.where(give > 0.0, self.share * np.maximum(-rows.gap[:k], 0.0) / safe, 0.0)
        multipliers[:], force[:] = 0.0, 0.0
        multipliers[0, rows.slot[:k]] = push
        np.add.at(force, node, rows.normal_weight[:z] * push[row, None])
        if len(multipliers) > 1:
            across = np.bincount(row, (rows.tangent_weight[:z] ** 2 * compliance[node]).sum(axis=1), k)
            mu, adhesion, cap = rows.bound[:, :k]
            capped = np.where(np.isfinite(cap), np.where(np.isfinite(cap), cap, 0.0) * push, np.inf)
            most = mu * push + np.minimum(adhesion * rows.measure[:k], capped)
            wish = np.clip(-self.share * rows.slip[:k] / np.where(across > 0.0, across, 1.0), -most, most)
            rub = np.where(across > 0.0, wish, 0.0)
            multipliers[1, rows.slot[:k]] = rub
            np.add.at(force, node, rows.tangent_weight[:z] * rub[row, None])
        moved = float(np.abs(compliance * force).max(initial=0.0))
        return Solve(1, 0.0, int((give == 0.0).sum()), moved)
