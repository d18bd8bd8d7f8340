"""Texts in `results.vtkhdf`, each a dataset of bytes of fixed length with a checksum.

HDF5 keeps texts of variable length in a heap without checksums, and a damage there can make it loop for ever; a file
written here has none. Files of format 3 had them, and are still read.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import h5py
import numpy as np

from contactlab.results.checksums import SEAL, seal_of, sealed

COLUMNS = "columns"


def write_text(group: h5py.Group, name: str, text: str) -> h5py.Dataset:
    """Write a text as dataset `name`, and seal it."""
    return _write(group, name, np.frombuffer(text.encode(), np.uint8))


def read_text(group: h5py.Group, name: str) -> str:
    """Read the text that `write_text` wrote. Raises Damage."""
    content: Any = sealed(group, name)
    return str((content if isinstance(content, bytes) else content.tobytes()).decode())


def write_columns(own: h5py.Group, table: str, names: Sequence[str]) -> None:
    """Write the names of the columns of a table of the group `contactlab` as its dataset `columns/<table>`, once."""
    group = own.require_group(COLUMNS)
    if table not in group:
        _write(group, table, np.array([name.encode() for name in names], "S"))


def read_columns(own: h5py.Group, table: str) -> list[str]:
    """Read the names that `write_columns` wrote, or the attribute of format 3. Raises Damage."""
    if f"{COLUMNS}/{table}" in own:
        return [name.decode() for name in sealed(own, f"{COLUMNS}/{table}").tolist()]
    attributes = own[table].attrs
    return [str(name) for name in attributes["names" if "names" in attributes else "columns"]]


def _write(group: h5py.Group, name: str, content: np.ndarray) -> h5py.Dataset:
    dataset = group.create_dataset(name, data=content)
    dataset.attrs[SEAL] = seal_of(dataset)
    return dataset
