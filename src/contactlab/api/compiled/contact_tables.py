"""Rows and gradients of `contactlab.api` as tables, for kernels that `unpack` an address; others take the objects."""

from __future__ import annotations

from contactlab.api.compiled.unpack import Table
from contactlab.api.derivatives import GapGradients
from contactlab.api.enforcement import FactoredGradients, FactoredRows, Rows

RowsTable, FactoredTable = Table(Rows), Table(FactoredRows)
FactoredGradientsTable, GradientsTable = Table(FactoredGradients), Table(GapGradients)
