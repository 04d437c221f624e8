"""Pages are made from templates: text of ours around what is given."""

from __future__ import annotations

from typing import Any


def filled_in(template: str, **content: Any) -> str:
    """Return a template of Jinja with its content, which is escaped. Raise UndefinedError where a name isn't given."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    return environment.from_string(template).render(**content)
