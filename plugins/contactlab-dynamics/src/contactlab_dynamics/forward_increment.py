"""Forward-increment Lagrange multipliers (Carpenter, Taylor & Katona 1991), by active sets or Gauss-Seidel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from contactlab.api import ExplicitEnforcement, FactoredGradients, FactoredRows, Floats, Rows, Solve
from contactlab.api.compiled.late import late

DENSE_UP_TO = 128  # conditions; above, forming their compliance costs more than the sweeps that it saves


@dataclass(frozen=True)
class ForwardIncrement(ExplicitEnforcement):
    """Multipliers at t_n, gap conditions at t_{n+1}: y >= 0, g >= 0, y g = 0 (docs/theory/forward-increment.md).

    With consistent forces g is the gap beyond the one that each condition may keep (contact-energy.md).

    forces     "consistent": along the derivatives of the gaps, which makes no energy (contact-energy.md);
               "frozen": along weights and normals at the end of the step; "conjugate", "published", "auto"
               are older names, the last of "consistent"
    tolerance  natural residual in segment lengths at which the sweeps stop
    sweeps     most sweeps in a step; a residual left over is reported
    """

    factored: ClassVar[bool] = True

    forces: Literal["consistent", "frozen", "conjugate", "published", "auto"] = "consistent"
    tolerance: float = 1e-10
    sweeps: int = 200

    def __post_init__(self) -> None:
        if not 0.0 < self.tolerance < 1.0:
            raise ValueError(f"tolerance: got {self.tolerance}, allowed: 0 < tolerance < 1")
        if self.sweeps < 1:
            raise ValueError(f"sweeps: got {self.sweeps}, allowed: at least 1")

    def solve(
        self, rows: Rows | FactoredRows | FactoredGradients, compliance: Floats, multipliers: Floats, force: Floats
    ) -> Solve | None:
        """Solve active sets by conjugate gradients, None if they cycle; sweep over `Rows`."""
        given = rows.count, rows, compliance, multipliers, force, self.tolerance, self.sweeps
        if not isinstance(rows, Rows):
            kernels = late("contactlab_dynamics.active_set")
            find = kernels.solve_active if isinstance(rows, FactoredRows) else kernels.solve_gradients
            passes, residual, largest = find(*given)
            return Solve(passes, residual, 0, largest) if residual <= self.tolerance else None
        kernels = late("contactlab_dynamics.gauss_seidel")
        conditions = rows.count * (2 if len(rows.tangent_weight) else 1)
        solve = kernels.solve_dense if conditions <= DENSE_UP_TO else kernels.solve_sparse
        return Solve(*solve(*given))
