"""A recorded episode as a picture or an animation."""

from jaxwalk.viewer.files import ViewerError, animation, picture

__all__ = ["ViewerError", "animation", "picture"]
