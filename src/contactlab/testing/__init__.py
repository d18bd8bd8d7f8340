"""Conformance checks: what every part of a kind must do, as plain functions that take one part.

One module per kind, each with its `CHECKS`. In a plugin's own tests:

    import pytest
    from contactlab.testing import material
    from my_package import MyLaw

    @pytest.mark.parametrize("check", material.CHECKS)
    def test_my_law(check):
        check(MyLaw(young=7000.0, poisson=0.3, density=2.7e-9))

A check returns nothing and raises AssertionError with what it got, what is allowed and why; it raises
`NotApplicable` (pytest skips) if the part declares that it does not offer the property, and `Expected` if the
part misses what it never promised. A warning `Undeclared` names a property that a part has but does not declare.
`contactlab check` runs these, and after them scenarios and cases (docs/check.md).
"""

from contactlab.testing.assertions import Expected, NotApplicable, Undeclared
from contactlab.testing.run import Outcome, checks_for, run_check, run_checks

__all__ = ["Expected", "NotApplicable", "Outcome", "Undeclared", "checks_for", "run_check", "run_checks"]
