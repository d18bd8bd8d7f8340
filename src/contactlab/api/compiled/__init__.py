"""Compiled code for plugins: the kernel decorators, bound arrays, late imports. Imports numba when used."""
