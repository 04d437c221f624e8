"""Where scenarios come from: a source gives them by number, whatever made them."""

from jaxwalk.scenarios.drawn import Drawn
from jaxwalk.scenarios.source import Source, source_hash

__all__ = ["Drawn", "Source", "source_hash"]
