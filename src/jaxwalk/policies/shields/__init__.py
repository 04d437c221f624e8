"""Shields: what each of them does instead of an action that isn't safe by its rule (``docs/shields.md``)."""
