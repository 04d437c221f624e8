"""The street: scenarios, how everybody moves, what the car perceives, views and rewards. Start at `environment.py`."""
