"""Recorded episodes as a picture, an animation or an interactive page."""

from jaxwalk.viewer.files import ViewerError, animation, picture
from jaxwalk.viewer.replay import replay_page

__all__ = ["ViewerError", "animation", "picture", "replay_page"]
