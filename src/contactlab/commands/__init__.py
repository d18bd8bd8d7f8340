"""The commands of the `contactlab` program, one module each, imported when they are typed."""
