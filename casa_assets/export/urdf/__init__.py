"""Asset -> URDF package: one module per concept, the same names as in the other two writers.

URDF puts the axis of a joint through the origin of the link that it moves. So the frame of a link of the URDF stands on
the anchor of its joint, and what is in the link is moved by as much; where the anchor is zero, both are the same.
"""

from casa_assets.export.urdf.document import write

__all__ = ["write"]
