"""Studies: each answers one question and is one command."""
