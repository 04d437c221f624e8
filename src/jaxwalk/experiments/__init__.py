"""Studies: each answers one question with one command."""
