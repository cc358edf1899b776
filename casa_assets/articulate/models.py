"""What was learned from labelled cases, handed in by whoever reads the registry."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.core.forest import Forest


@dataclass(frozen=True)
class Models:
    """Forests that decide where rules decide worse.

    Attributes:
        plans: tells how good a plan is, in GRADES, from PLAN_FEATURES; None where rules decide.
        controls: tells knobs, keys and neither, from CONTROL_FEATURES; None to look at each control alone.
    """

    plans: Forest | None = None
    controls: Forest | None = None
