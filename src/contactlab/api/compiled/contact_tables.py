"""Rows and gradients of `contactlab.api` as tables, for kernels of the core that `unpack` their addresses."""

from __future__ import annotations

from contactlab.api.compiled.unpack import Table
from contactlab.api.derivatives import GapGradients
from contactlab.api.enforcement import FactoredGradients, FactoredRows, Rows

RowsTable, FactoredTable = Table(Rows), Table(FactoredRows)
FactoredGradientsTable, GradientsTable = Table(FactoredGradients), Table(GapGradients)
