"""Failure search: where in the cube of all draws a driver touches somebody, and how rare that is."""
