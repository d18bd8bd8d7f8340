"""Cutting a body into blocks."""

from __future__ import annotations

from contactlab.api import BLOCK_CELLS
from contactlab.model.bodies.body import block_size


def test_rows_of_a_block_do_not_share_their_cache_sets() -> None:
    """Rows a multiple of 2 KiB apart would; blocks stay within bounds and large enough to hide their calls."""
    for cells in [*range(1, 4000), 4096, 16384, 100_000, 1_000_000]:
        size = block_size(cells)
        width = min(size, cells)
        assert 1 <= size <= BLOCK_CELLS
        assert width % 256
        assert cells <= BLOCK_CELLS or size >= BLOCK_CELLS // 2
