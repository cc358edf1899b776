"""Rules as SimReady has them, for tests of what runs them. SimReady's packages are installed where this is imported."""

from __future__ import annotations

from typing import Any

import usd_validation_nvidia
from pxr import Usd
from simready.validate import api as simready_api

from casa_assets.checks import simready

__all__ = ["simready", "simready_api"]

Event, Kind = usd_validation_nvidia.ComplianceCheckerEvent, usd_validation_nvidia.ComplianceCheckerEventType
Checker = usd_validation_nvidia.ComplianceChecker
TheirRunner = usd_validation_nvidia._compliance_runners.SyncComplianceCheckerRunner


class Looker(usd_validation_nvidia.BaseRuleChecker):
    """Notes what it is given."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[object] = []

    def CheckPrim(self, prim: Usd.Prim) -> None:  # noqa: N802  the validator calls it so
        """Note a prim; one called `bad` is too much for it."""
        self.seen.append(prim.GetName())
        if prim.GetName() == "bad":
            raise RuntimeError("too much")


class Stager(usd_validation_nvidia.BaseRuleChecker):
    """Looks at stages alone."""

    def CheckStage(self, stage: Usd.Stage) -> None:  # noqa: N802
        self._AddFailedCheck(message="a stage")


class Two(usd_validation_nvidia.BaseRuleChecker):
    """Looks for two requirements."""

    def CheckPrim(self, prim: Usd.Prim) -> None:  # noqa: N802
        """Look for both."""
        self.check_vm_tex_001_size(prim)
        self.check_vm_pbr_001_surface(prim)

    def check_vm_tex_001_size(self, prim: Usd.Prim) -> None:
        self._AddFailedCheck(message=f"size of {prim.GetName()}")

    def check_vm_pbr_001_surface(self, prim: Usd.Prim) -> None:
        self._AddFailedCheck(message=f"surface of {prim.GetName()}")


def events(stage: Usd.Stage) -> list[Any]:
    """What the validator asks of its rules on a stage, in its order."""
    prims = [Event(Kind.PRIM, prim) for prim in stage.Traverse()]
    return [Event(Kind.STAGE, stage), Event(Kind.FLUSH, None), *prims, Event(Kind.RESET_CACHE, None)]


def registered(requirement: str) -> Any:
    """The rule that is registered for a requirement."""
    simready.load_rules()
    registry = usd_validation_nvidia.RequirementsRegistry()
    return registry.get_validator(registry.find_requirement(requirement))
