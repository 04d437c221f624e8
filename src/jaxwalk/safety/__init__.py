"""Formulas of safety that drivers, shields and metrics share: pure functions, each with its source."""
