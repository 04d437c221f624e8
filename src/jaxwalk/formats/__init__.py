"""Standard file formats: reads and writes trajectories, writes scenarios (``docs/trajectories.md``)."""
