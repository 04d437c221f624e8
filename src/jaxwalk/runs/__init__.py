"""Run folders: training into them, studies of several, and drivers and populations found by name."""
