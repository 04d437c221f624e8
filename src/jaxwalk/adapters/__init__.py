"""Other people's interfaces and file formats."""
