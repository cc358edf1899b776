"""Imported once by the fork server for its effect: heavy libraries, rules and registry are ready in every child."""

from casa_assets import registry
from casa_assets.checks import usd
from casa_assets.pipeline import worker  # noqa: F401

registry.load()
usd.load_rules()
