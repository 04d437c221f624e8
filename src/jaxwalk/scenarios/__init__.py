"""Sources of scenarios: a source gives scenarios by number, however they were made."""

from jaxwalk.scenarios.archived import Archived
from jaxwalk.scenarios.drawn import Drawn
from jaxwalk.scenarios.scripted import Scripted
from jaxwalk.scenarios.source import Source, source_hash

__all__ = ["Archived", "Drawn", "Scripted", "Source", "source_hash"]
