"""Episodes in other people's file formats: trajectories out and in, scenarios out (``docs/trajectories.md``)."""
