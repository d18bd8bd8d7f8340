"""Compiled code for parts: the kernel decorators, bound arrays, late imports. Imports numba when used."""
