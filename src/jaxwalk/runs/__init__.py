"""One training: its recipe, its folder on disk, the loop that trains, and what can be watched meanwhile."""
