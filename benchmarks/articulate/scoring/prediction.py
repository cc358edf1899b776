"""Found parts as score.py of the articulation benchmark reads them."""

from __future__ import annotations

from typing import Any

import numpy as np

from casa_assets.articulate.plan import Frame, JointPlan, PartPlan
from casa_assets.core.numeric import Ints


def part_row(part: PartPlan, joint: JointPlan, frame: Frame, faces: Ints) -> dict[str, Any]:
    """A part with its joint in the axes and units of the file.

    Args:
        joint: of the part, in the frame. faces: (F,) faces of the part in the order of the file.
    """
    slides = joint.kind.value == "slide"
    row = {
        "type": "prismatic" if slides else "continuous" if joint.endless else "revolute",
        "axis": list(frame.direction_to_file(joint.axis)),
        "origin": frame.to_file(np.array([joint.anchor]))[0].tolist(),
        "range": [r / frame.scale if slides else r for r in joint.range],
    }
    parent = part.parent or "base"
    return {"name": part.name, "type": part.kind.value, "parent": parent, "joint": row, "faces": faces.tolist()}
