"""Streets from maps of the real world: readers of formats, and what makes streets of what they read."""
