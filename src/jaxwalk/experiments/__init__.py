"""Recipes, runs on disk, and the paper's tables as plain lists of runs."""
