"""Content that is built into articulated meshes: walls and furniture of cavities, and boxes of drawers."""

from casa_assets.kitchenware.parts.drawers import add_drawer_box
from casa_assets.kitchenware.parts.interiors import FURNISHERS, Interior, add_walls

__all__ = ["FURNISHERS", "Interior", "add_drawer_box", "add_walls"]
