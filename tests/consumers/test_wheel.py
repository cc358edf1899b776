"""The wheel carries what the program needs away from a checkout, and nothing that it does not."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from casa_assets.registry import FILES
from tests.support.program.environments import Environment

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.consumers
# Run in an environment that has nothing else of ours, whose folder takes the place of FOLDER.
PROBE = """
import pathlib
import casa_assets
from casa_assets import registry
from casa_assets.show.reports import kitchens

for place in (pathlib.Path(casa_assets.__file__), registry.data_root()):
    assert place.is_relative_to("FOLDER"), place
assert registry.data_root().name == "registry_data"
assert len(registry.load().categories) > 100
assert "<html" in kitchens.index_page([], "Kitchens")
"""


def test_registry_and_templates_are_inside_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    wanted = {f"casa_assets/registry_data/{name}.yaml" for name in FILES}
    templates = (ROOT / "casa_assets" / "show" / "page" / "templates").rglob("*")
    wanted |= {path.relative_to(ROOT).as_posix() for path in templates if path.is_file()}
    assert "casa_assets/show/page/templates/frame/base.html" in wanted
    wanted |= {f"casa_assets/show/page/bundle/{name}" for name in ("viewer.js", "LICENSES.txt")}
    wanted |= {path.relative_to(ROOT).as_posix() for path in (ROOT / "casa_assets").rglob("*.py")}
    assert sorted(wanted - set(names)) == []
    packages = {name.split("/", 1)[0] for name in names}
    assert {p for p in packages if not p.endswith(".dist-info")} == {"casa_assets"}
    assert [name for name in names if "test" in name or "example" in name or name.endswith(".pyc")] == []


def test_the_program_runs_from_the_wheel(user: Environment, tmp_path: Path) -> None:
    user.python(PROBE.replace("FOLDER", str(user.folder)), cwd=tmp_path)
