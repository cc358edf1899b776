"""Run SimReady's rules on a USD file in this process.

Other Pythons run this module too (see `child.py`): what it imports needs numpy, usd-core and SimReady's own packages.
"""

from __future__ import annotations

import importlib.metadata
import inspect
from contextlib import suppress
from functools import cache
from pathlib import Path
from unittest.mock import patch

from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.simready.installed import NEEDED

PROFILE = "Robotics-Prop"
PROFILE_VERSION = "4.0.0"
# Whether a file passes, and code -> message of each requirement that the profile demands and that is not met.
Verdict = tuple[bool, dict[str, str]]


def validate(path: Path, without: frozenset[str] = frozenset()) -> Verdict | None:
    """Validate a USD file as SimReady's command line does.

    Args:
        without: codes of requirements that need not be run, since the caller does not count them.
    Returns:
        The verdict, or None if the validator returns no result.
    Raises:
        ImportError: SimReady's packages are not installed here.
    """
    load_rules()
    import simready.validate
    from simready.validate.api import features_summary_passed

    from casa_assets.checks.simready.rule_runner import only_demanded

    config = simready.validate.AssetValidationConfig(
        asset_path=str(path), profile_id=PROFILE, profile_version=PROFILE_VERSION
    )
    with only_demanded(without):
        result = simready.validate.validate_asset(config)
    if result is None:
        return None
    failures: dict[str, str] = {}
    for issue in result.issues:
        failures.setdefault(issue.requirement.code if issue.requirement else str(issue.rule), issue.message)
    # Not `passed` of the features: those that the profile calls optional say False where they are not used.
    return features_summary_passed(result.features_summary), failures


def _register_rules_only_once() -> None:
    """Keep the tier's plug-in from registering its rules when the validator is imported.

    `simready.validate.initialize` takes out all that was registered and registers it again, which takes longer than all
    else. The plug-in does nothing but import the rules. Also, to find tests of the tier, which nobody runs here, it
    would read the list of files of every installed package.
    """
    named = {"simready": [*NEEDED]}
    absent = suppress(AttributeError, ImportError)
    with patch.object(importlib.metadata, "packages_distributions", lambda: named), absent:
        plugin = importlib.import_module("simready.foundation.tier_core._plugin")
        plugin.SimReadyPlugin.on_startup = lambda _: None


@cache
def load_rules() -> None:
    """Register the rules of SimReady, once per process (a second with their import). Raises ImportError."""
    _register_rules_only_once()
    import simready.validate

    from casa_assets.checks.simready import coincident_meshes, rule_runner

    with quiet():
        simready.validate.initialize([], [], [])
        coincident_meshes.make_swift()
        rule_runner.run_rules_directly()
    # The validator asks for the caller's module when it warns of a name of its own that is old; the first to ask looks
    # through all modules that are loaded.
    inspect.getmodule(inspect.currentframe())
