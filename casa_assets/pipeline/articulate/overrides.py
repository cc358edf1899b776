"""Apply what a person wrote about an input into review.csv of a library to the request to articulate it."""

from __future__ import annotations

from dataclasses import replace

from casa_assets.model.ingest.user_override import UpAxis, UserOverride
from casa_assets.pipeline.articulate.build import ArticulateRequest

_UP_WORDS = {axis: ("-" if axis.startswith("minus_") else "+") + axis[-1] for axis in UpAxis}


def with_override(request: ArticulateRequest, override: UserOverride) -> ArticulateRequest:
    """Return the request with what review.csv says; what the request or its decisions say themselves goes before it."""
    said = request.decisions
    decisions = said.replace(
        category=said.category or override.category or None,
        up=said.up if said.up is not None else _UP_WORDS.get(override.up) if override.up is not None else None,
        size_m=said.size_m or override.size_m or None,
        decision=said.decision or override.decision,
    )
    return request if decisions == said else replace(request, decisions=decisions)
