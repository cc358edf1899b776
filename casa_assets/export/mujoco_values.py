"""Values that MuJoCo reads from both formats: groups of geoms and sites, and contact dimensions."""

from __future__ import annotations

from casa_assets.model.asset.asset import Site
from casa_assets.model.asset.shape import Shape, Sphere

# Ref: robosuite, geoms of group 0 collide and geoms of group 1 are drawn.
COLLIDER_GROUP, VISUAL_GROUP = 0, 1
# The viewer hides sites of group 3 until asked for them.
SITE_GROUP = 3
# Flames and streams, which runtimes show by raising their alpha, are in a group that every camera sees.
EFFECT_GROUP = 1

# With sliding friction alone (3) a ball that spins never stops; 4 adds spinning. Ref: robosuite's objects.
FACETED_CONTACT = 4
# A sphere has no face to rest on: only rolling friction stops it, and only 6 turns that on.
ROUND_CONTACT = 6


def contact_dimensions(shape: Shape) -> int:
    """MuJoCo's `condim` of a shape."""
    return ROUND_CONTACT if isinstance(shape, Sphere) else FACETED_CONTACT


def site_group(site: Site) -> int:
    """Group of a site: one that is fully transparent is an effect."""
    return SITE_GROUP if site.color[3] else EFFECT_GROUP
