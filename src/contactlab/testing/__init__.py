"""Conformance checks: what every part of a kind must do, as plain functions that take one part.

One module per kind, each with its `CHECKS`. In a plugin's own tests:

    import pytest
    from contactlab.testing import material
    from my_package import MyLaw

    @pytest.mark.parametrize("check", material.CHECKS)
    def test_my_law(check):
        check(MyLaw(young=7000.0, poisson=0.3, density=2.7e-9))

A check returns nothing and raises AssertionError with what it got, what is allowed and why; it raises
`NotApplicable` (pytest skips) where the part declares that it does not offer what is checked.
"""

from contactlab.testing.assertions import NotApplicable
from contactlab.testing.run import Outcome, checks_for, run_check, run_checks

__all__ = ["NotApplicable", "Outcome", "checks_for", "run_check", "run_checks"]
