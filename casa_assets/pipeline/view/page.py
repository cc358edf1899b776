"""The page on which a model is turned, opened and swapped; all that it shows it asks the server for."""

from __future__ import annotations

from markupsafe import Markup

from casa_assets.pipeline.reports.page_template import render_template
from casa_assets.pipeline.viewer.viewer_file import viewer_script


def page(first: str, pose: str = "") -> str:
    """HTML of the page.

    Args:
        first: id of the model that it asks for first. pose: in which that is shown; empty: as it begins.
    """
    viewer = Markup(viewer_script().decode())  # noqa: S704  a file of this package
    return render_template("view/page.html", title=first, start={"first": first, "pose": pose}, viewer=viewer)
