"""Recorded episodes as a picture, an animation or an interactive page."""

from jaxwalk.viewer.episode_figure import EpisodeFigure, ViewerError
from jaxwalk.viewer.files import animation, picture
from jaxwalk.viewer.replay import replay_page

__all__ = ["EpisodeFigure", "ViewerError", "animation", "picture", "replay_page"]
