"""One episode's physics and rules: scenario in, states and events out. Start at `environment.py`."""
