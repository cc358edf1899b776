"""Imported once by the fork server, on purpose for its effect: heavy libraries and the registry are ready in every child."""

from casa_assets import registry
from casa_assets.pipeline import worker  # noqa: F401

registry.load()
