"""HTML pages from the templates of the folder `templates/`: one frame for all of them, every value escaped."""

from __future__ import annotations

from functools import lru_cache
from importlib.metadata import version
from importlib.resources import files
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

FOLDER = "templates"

# What a page with models may load: scripts beside it, and the pictures inside a model, which the viewer hands itself.
MODEL_POLICY = Markup("script-src 'unsafe-inline' 'self' file:; connect-src blob:; worker-src blob:")


def render_template(name: str, **values: Any) -> str:
    """Text of a template of the folder `templates/`, filled in.

    Args:
        name: of the template, such as `library/page.html`; it has to stand in the caller's code as text, which makes
            the template, and what it takes in, a part of the caller's cache key.
        values: what the template shows; text in it is escaped, only `Markup` goes in as it is.
    Raises:
        jinja2.UndefinedError: a value that the template shows is not given.
    """
    return _environment().get_template(name).render(version=version("casa-assets"), **values)


def relative_link(path: str) -> str:
    """The URL of a path relative to the page; `./` in front keeps a colon from being read as a scheme."""
    return "./" + quote(path.lstrip("/"))


@lru_cache(maxsize=1)
def _environment() -> Environment:
    made = Environment(
        loader=FunctionLoader(_source),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.policies["json.dumps_kwargs"] = {"sort_keys": True, "separators": (",", ":"), "allow_nan": False}
    made.globals["source"] = _unescaped_source
    made.globals["model_policy"] = MODEL_POLICY
    made.filters["relative_link"] = relative_link
    return made


def _source(name: str) -> str:
    return files("casa_assets.pipeline.reports").joinpath(FOLDER, name).read_text(encoding="utf-8")


def _unescaped_source(name: str) -> Markup:
    """A style sheet or script of ours, as it stands in its file."""
    return Markup(_source(name))  # noqa: S704  a file of this package
