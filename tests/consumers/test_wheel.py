"""The wheel carries what the program needs away from a checkout, and nothing that it does not."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from casa_assets.registry import FILES

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.consumers

PROBE = """
import pathlib, sys
import casa_assets
from casa_assets import registry
from casa_assets.show.reports import kitchens

assert pathlib.Path(casa_assets.__file__).is_relative_to(sys.argv[1]), casa_assets.__file__
assert registry.data_root().name == "registry_data"
assert len(registry.load().categories) > 100
assert "<html" in kitchens.index_page([], "Kitchens")
"""


@pytest.fixture(scope="module")
def names(wheel: Path) -> list[str]:
    """Paths of the files in the wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return archive.namelist()


def test_registry_and_templates_are_inside(names: list[str]) -> None:
    wanted = {f"casa_assets/registry_data/{name}.yaml" for name in FILES}
    templates = (ROOT / "casa_assets" / "show" / "page" / "templates").rglob("*")
    wanted |= {path.relative_to(ROOT).as_posix() for path in templates if path.is_file()}
    assert "casa_assets/show/page/templates/frame/base.html" in wanted
    wanted |= {f"casa_assets/show/page/bundle/{name}" for name in ("viewer.js", "LICENSES.txt")}
    wanted |= {path.relative_to(ROOT).as_posix() for path in (ROOT / "casa_assets").rglob("*.py")}
    assert sorted(wanted - set(names)) == []


def test_nothing_else_is_inside(names: list[str]) -> None:
    packages = {name.split("/", 1)[0] for name in names}
    assert {p for p in packages if not p.endswith(".dist-info")} == {"casa_assets"}
    assert [name for name in names if "test" in name or "example" in name or name.endswith(".pyc")] == []


def test_the_program_runs_from_the_wheel(wheel: Path, tmp_path: Path) -> None:
    """Unpacked beside nothing else of ours, with the dependencies of this environment."""
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    # -P and a path of its own: neither the checkout nor the working directory may stand in for what is missing.
    code = f"import sys; sys.path.insert(0, {str(site)!r})\n{PROBE}"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code, str(site)],
        cwd=tmp_path,
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
