"""An interrupt while a kernel is compiled ends the program as one, and the kernel is compiled at its next call."""

from __future__ import annotations

import numpy as np
import pytest
from numba.core.codegen import CPUCodeLibrary

from contactlab.api.compiled.kernel import kernel


def test_an_interrupt_that_a_callback_drops_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """LLVM hands machine code over in a callback; what a signal raises in it is dropped, and the code is missing."""

    @kernel
    def twice(values: np.ndarray) -> None:
        values *= 2.0

    with monkeypatch.context() as patched:
        patched.setattr(CPUCodeLibrary, "_compiled_object", property(lambda self: None, lambda self, code: None), False)
        with pytest.raises(KeyboardInterrupt):
            twice(np.ones(3))
    values = np.ones(3)
    twice(values)
    assert values.tolist() == [2.0, 2.0, 2.0]
