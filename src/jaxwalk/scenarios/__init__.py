"""Sources of scenarios: a source gives scenarios by number, however they were made."""

from jaxwalk.scenarios.drawn import Drawn
from jaxwalk.scenarios.source import Source, source_hash

__all__ = ["Drawn", "Source", "source_hash"]
