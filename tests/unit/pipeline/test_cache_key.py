"""Keys of kept results follow the code, the registry and the packages that the results depend on, and nothing else."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from casa_assets.pipeline.cache_key import PACKAGE

ROOT = Path(__file__).parents[3]

# Prints the keys of everything that is kept, by name.
REPORT = """
import json
from casa_assets.families.catalog import FAMILIES
from casa_assets.pipeline import scene_check, scenes
from casa_assets.pipeline.families import asset_key
from casa_assets.pipeline.kitchens import Recipe
from casa_assets.pipeline.stage import STAGES, stage_key
from casa_assets.pipeline.textures import finish_key, recipes

found = {f"stage {stage.name}": stage_key(stage) for stage in STAGES}
found |= {f"texture {n} {r.kind}": finish_key(r) for rows in recipes().values() for n, r in rows.items()}
for name, family in FAMILIES.items():
    found |= {f"asset {name} {preset}": asset_key(family, p) for preset, p in family.presets.items()}
for recipe in (Recipe("l_small", "coastal"), Recipe("one_wall_small", "rustic", seed=3)):
    found[f"scene {recipe.scene_id}"] = key = scenes.scene_key(recipe)
    found[f"pictures {recipe.scene_id}"] = scenes.picture_key(key)
    found[f"verdict {recipe.scene_id}"] = scene_check.verdict_key(recipe)
print(json.dumps(found))
"""


class Copy:
    """A copy of the package with its registry that may be changed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        skip = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / PACKAGE, folder / PACKAGE, ignore=skip)
        shutil.copytree(ROOT / "registry", folder / "registry")

    def keys(self, seed: str = "0") -> dict[str, str]:
        environment = {**os.environ, "PYTHONPATH": str(self.folder), "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", REPORT]
        done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        found: dict[str, str] = json.loads(done.stdout)
        return found

    def changed_by(self, path: str, old: str, new: str, before: dict[str, str]) -> set[str]:
        """Names of the keys that differ once a text is replaced in a file, which is put back."""
        target = self.folder / path
        text = target.read_text(encoding="utf-8")
        assert text.count(old) == 1, f"{old!r} occurs {text.count(old)} times in {path}"
        target.write_text(text.replace(old, new), encoding="utf-8")
        after = self.keys()
        target.write_text(text, encoding="utf-8")
        assert after.keys() == before.keys()
        return {name for name in before if after[name] != before[name]}


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Copy:
    return Copy(tmp_path_factory.mktemp("copy"))


@pytest.fixture(scope="module")
def before(copy: Copy) -> dict[str, str]:
    return copy.keys()


def of(names: set[str], word: str) -> set[str]:
    return {name for name in names if name.startswith(f"{word} ")}


class TestOneConstantChanges:
    def test_nothing_without_it(self, copy: Copy, before: dict[str, str]) -> None:
        assert copy.keys(seed="7") == before

    def test_in_a_kind_of_texture(self, copy: Copy, before: dict[str, str]) -> None:
        """The textures of that kind, and what shows them."""
        changed = copy.changed_by(*KIND, before)
        assert of(changed, "texture") == {n for n in before if n.startswith("texture ") and n.endswith(" beadboard")}
        assert of(changed, "stage") == set()
        assert 0 < len(of(changed, "asset")) < len(of(set(before), "asset")) / 4

    def test_in_the_preview(self, copy: Copy, before: dict[str, str]) -> None:
        """Pictures, and verdicts on them, and no geometry."""
        changed = copy.changed_by(*PREVIEW, before)
        assert changed == of(set(before), "pictures") | of(set(before), "verdict")

    def test_in_a_stage(self, copy: Copy, before: dict[str, str]) -> None:
        assert copy.changed_by(*STAGE, before) == {"stage mass"}

    def test_in_a_family(self, copy: Copy, before: dict[str, str]) -> None:
        """Its own assets, and the kitchens that have one."""
        changed = copy.changed_by(*FAMILY, before)
        assert of(changed, "asset") == {name for name in before if name.startswith("asset toaster ")}
        assert of(changed, "texture") | of(changed, "stage") == set()

    def test_in_a_plan(self, copy: Copy, before: dict[str, str]) -> None:
        """The kitchens of that plan alone."""
        changed = copy.changed_by(*PLAN, before)
        assert changed == {n for n in before if "l_small__" in n}


KIND = ("casa_assets/textures/kinds/walls/boards.py", "0.5", "0.25")
PREVIEW = ("casa_assets/preview/darkroom.py", "0.5", "0.25")
STAGE = ("casa_assets/ingest/mass.py", "0.5", "0.25")
FAMILY = ("casa_assets/families/fixtures/small/toaster.py", "0.5", "0.25")
PLAN = ("registry/plans/l_small.yaml", "0.5", "0.25")
