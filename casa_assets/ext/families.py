"""Families of parametric assets: their parameters, finishes and declaration."""

from __future__ import annotations

from casa_assets.asset.assemble import Family
from casa_assets.asset.family import AvailableFinishes, FinishId, Params, between, pick
from casa_assets.core import hand_dynamics
from casa_assets.core.hand_dynamics import TAP_START_N

__all__ = [
    "AvailableFinishes",
    "between",
    "Family",
    "FinishId",
    "hand_dynamics",
    "Params",
    "pick",
    "TAP_START_N",
]
