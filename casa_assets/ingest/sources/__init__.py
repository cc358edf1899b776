"""Sources of raw meshes: folders, Objaverse packages, text-to-3D deliveries, plain manifests."""

from __future__ import annotations

from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.places import Found, Refused

__all__ = ["Found", "Refused", "collect", "discover"]
