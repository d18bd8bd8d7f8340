"""Compiled helpers on chains of segments, for contact algorithms. Imports numba when it is imported."""

from __future__ import annotations

from contactlab.kernels.edges import nodal_normals, segment_normals, tributary_lengths

__all__ = ["nodal_normals", "segment_normals", "tributary_lengths"]
