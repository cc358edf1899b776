"""Rules as SimReady has them, for tests of what runs them. SimReady's packages are installed where this is imported."""

from __future__ import annotations

from typing import Any

import usd_validation_nvidia
from simready.validate import api as simready_api

from casa_assets.checks import simready

__all__ = ["simready", "simready_api"]

Checker = usd_validation_nvidia.ComplianceChecker
TheirRunner = usd_validation_nvidia._compliance_runners.SyncComplianceCheckerRunner


def registered(requirement: str) -> Any:
    """The rule that is registered for a requirement."""
    simready.load_rules()
    registry = usd_validation_nvidia.RequirementsRegistry()
    return registry.get_validator(registry.find_requirement(requirement))
