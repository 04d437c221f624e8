"""`jaxwalk live`: a small server on the loopback address, whose page plays scenarios as they happen (docs/live.md)."""
