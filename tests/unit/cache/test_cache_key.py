"""Keys of kept results follow the code, the registry and the packages that the results depend on, and nothing else."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.cache import cache_key
from casa_assets.cache.cache_key import reach
from casa_assets.cache.code_index import PACKAGE, package_files, scan, target
from tests.support.library.libraries import write_files

pytestmark = pytest.mark.content("code", "cache", keep=0)

ROOT = Path(__file__).parents[3]
PARTS = 5  # of the package, each of which is parsed by itself
# What loads a module by a name that is worked out while the program runs.
LOADERS = {"importlib.import_module", "import_module", "__import__"}
# Of so many families, the keys of all presets are looked at.
FAMILIES = ("toaster", "microwave", "switch", "rug", "room_wall", "vase")
# Loads the package and then, once for each line (paths to look for modules at), prints the keys of everything that is
# kept, by name, from a process of its own: none of them has read a file of the package before.
REPORT = f"""
import json, os, sys
from casa_assets.articulate.run.steps import _code_key
from casa_assets.families.build import asset_key
from casa_assets.ingest.run import run as ingest
from casa_assets.ingest.run.steps import STAGES, stage_key
from casa_assets.layouts.run import check, scene_folders, scene_page
from casa_assets.layouts.run.resolve import SceneRecipe
from casa_assets.textures.run.recipes import finish_key, recipes
from casa_assets.registry.families import family

def report():
    found = {{f"stage {{stage.name}}": stage_key(stage) for stage in STAGES}}
    found |= {{f"texture {{n}} {{r.kind}}": finish_key(r) for rows in recipes().values() for n, r in rows.items()}}
    for name in {FAMILIES}:
        presets = family(name).presets
        found |= {{f"asset {{name}} {{preset}}": asset_key(family(name), p) for preset, p in presets.items()}}
    for recipe in (SceneRecipe("l_small", "coastal"), SceneRecipe("one_wall_small", "rustic", seed=3)):
        found[f"scene {{recipe.scene_id}}"] = key = scene_folders.scene_key(recipe)
        found[f"pictures {{recipe.scene_id}}"] = scene_folders.picture_key(key)
        found[f"verdict {{recipe.scene_id}}"] = check.verdict_key(recipe)
    found["page of a scene"] = scene_page.page_key()
    found["model of a scene"] = scene_page.model_key()
    found["library ingest"] = ingest.cache_key({{}})
    found["code of articulate"] = _code_key()
    print(json.dumps(found), flush=True)

for line in sys.stdin:
    child = os.fork()
    if child == 0:
        sys.path[1:1] = json.loads(line)
        try:
            report()
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    print(flush=True)
"""


class Copy:
    """A copy of the package with its registry that may be changed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        skip = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / PACKAGE, folder / PACKAGE, ignore=skip)
        shutil.copytree(ROOT / "registry", folder / "registry")
        self._loaded = self.start("0")
        self.before = self.keys()

    def start(self, seed: str) -> subprocess.Popen[str]:
        environment = {**os.environ, "PYTHONPATH": str(self.folder), "PYTHONHASHSEED": seed}
        pipe = subprocess.PIPE
        return subprocess.Popen(
            [sys.executable, "-c", REPORT], cwd=self.folder, env=environment, stdin=pipe, stdout=pipe, text=True
        )

    def keys(self, besides: Sequence[Path] = (), process: subprocess.Popen[str] | None = None) -> dict[str, str]:
        """The keys by name. `besides`: more places of modules. `process`: that asks for them, of those of `start`."""
        asked = process or self._loaded
        assert asked.stdin is not None
        assert asked.stdout is not None
        asked.stdin.write(json.dumps([str(place) for place in besides]) + "\n")
        asked.stdin.flush()
        line = asked.stdout.readline()
        assert line.strip(), "it told its error"
        found: dict[str, str] = json.loads(line)
        assert asked.stdout.readline() == "\n"
        return found

    def changed_by(self, path: str, old: str, new: str) -> set[str]:
        """Names of the keys that differ once a text is replaced in a file, which is put back."""
        target = self.folder / path
        text = target.read_text(encoding="utf-8")
        assert text.count(old) == 1, f"{old!r} occurs {text.count(old)} times in {path}"
        target.write_text(text.replace(old, new), encoding="utf-8")
        after = self.keys()
        target.write_text(text, encoding="utf-8")
        assert after.keys() == self.before.keys()
        return {name for name in after if after[name] != self.before[name]}

    def names(self, word: str, end: str = "") -> set[str]:
        return {name for name in self.before if name.startswith(f"{word} ") and name.endswith(end)}


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Copy]:
    made = Copy(tmp_path_factory.mktemp("copy"))
    yield made
    made._loaded.communicate()


# A text in a file, what takes its place, and the names of the keys that differ then.
CHANGES = (
    ("casa_assets/show/stills/room_light.py", "_EXPOSURE = 0.78", "_EXPOSURE = 0.79", "(pictures|verdict) .*"),
    ("casa_assets/ingest/mass.py", "_RATIO = 1e-7", "_RATIO = 1e-6", "stage mass|library ingest"),
    ("casa_assets/show/page/bundle/viewer.js", "/* casa-assets viewer with", "/* the viewer with", "page of a scene"),
    ("registry/plans/l_small.yaml", "height: 2.7\n", "height: 2.71\n", ".* l_small__.*"),
)


def test_what_is_made_of_a_file_has_another_key_and_nothing_else(copy: Copy, subtests: pytest.Subtests) -> None:
    """Such as the pages that load the viewer, but neither verdicts of checks nor the models that it shows."""
    for path, old, new, names in CHANGES:
        with subtests.test(path=path):
            assert copy.changed_by(path, old, new) == {name for name in copy.before if re.fullmatch(names, name)}


def test_a_kind_of_texture_changes_those_of_its_module_and_what_shows_them(copy: Copy) -> None:
    changed = copy.changed_by("casa_assets/kitchenware/textures/wall_panels.py", "0.0004 * (np", "0.0005 * (np")
    kinds = (" ceramic_tile", " fired_clay", " stonework", " painted_boards", " concrete", " pressed_tin")
    those = {n for kind in kinds for n in copy.names("texture", kind)}
    assert changed & copy.names("texture") == those
    assert 0 < len(changed & copy.names("asset")) < len(copy.names("asset")) / 4
    assert changed.isdisjoint(copy.names("stage") | copy.names("library"))


def test_a_family_changes_its_own_assets_and_kitchens_that_have_one(copy: Copy) -> None:
    path = "casa_assets/kitchenware/fixtures/toasters.py"
    changed = copy.changed_by(path, "FOOT_HEIGHT = 0.008 ", "FOOT_HEIGHT = 0.009 ")
    assert changed & copy.names("asset") == copy.names("asset toaster")
    assert changed.isdisjoint(copy.names("texture") | copy.names("stage") | copy.names("library"))


def test_nothing_changes_with_the_process_or_packages_that_make_nothing(copy: Copy, tmp_path: Path) -> None:
    """Whoever has Ray, or the program that a written file is for, makes the same bytes as who has not."""
    other = copy.start("7")
    assert copy.keys(process=other) == copy.before
    other.communicate()
    for name in ("ray", "isaaclab"):
        told = f"Metadata-Version: 2.1\nName: {name}\nVersion: 98.7.6\n"
        files = {"METADATA": told, "top_level.txt": f"{name}\n"}
        write_files(tmp_path / f"{name}-98.7.6.dist-info", files)
        write_files(tmp_path / name, {"__init__.py": "raise ImportError('nothing imports it for a key')\n"})
    assert copy.keys(besides=(tmp_path,)) == copy.before


class TestImports:
    """What the quick look at a module's text finds, against what Python's own parser finds."""

    @pytest.mark.representatives(1)
    @pytest.mark.parametrize("part", range(PARTS))
    def test_every_import_of_the_package_is_found(self, part: int) -> None:
        for module, path in list(package_files().sources.items())[part::PARTS]:
            expected = _imports(ast.parse(path.read_text(encoding="utf-8")))
            found = scan(module)
            assert expected - {module} <= {*found.modules, *found.outside}, module

    def test_no_module_is_loaded_by_a_name_that_is_not_in_the_text(self) -> None:
        """Names are text of this package, or stand for packages of others."""
        loading = set()
        for module, path in package_files().sources.items():
            text = path.read_text(encoding="utf-8")
            if "import_module" not in text and "__import__" not in text:
                continue
            for node in ast.walk(ast.parse(text)):
                loads = isinstance(node, ast.Call) and ast.unparse(node.func) in LOADERS
                if loads and not isinstance(node.args[0], ast.Constant):
                    loading.add(module)
        # The server of workers is given names by those that call it, in whose text they stand; the renderer takes a
        # module of MuJoCo; the names that the package offers stand in a table of it; what opens our kitchens in
        # RoboCasa runs there and loads RoboCasa's modules.
        assert loading == {
            "casa_assets",
            "casa_assets.addons.robocasa.casa_kitchens",
            "casa_assets.runs.server",
            "casa_assets.show.stills.opengl",
        }

    def test_types_alone_are_left_out_and_imports_inside_functions_are_not(self) -> None:
        found = reach("casa_assets.layouts.run.scene_json")
        assert "casa_assets.layouts.run.resolve" not in found.modules, "imported under TYPE_CHECKING"
        assert "casa_assets.articulate.run.steps" in reach("casa_assets.cli.verbs.meshes:articulate").modules
        by_public_name = reach("casa_assets.addons.batch.merged_form").modules
        assert "casa_assets.model.asset.asset" in by_public_name
        assert "casa_assets" not in by_public_name, "its version would be in the key"
        named_in_text = reach("casa_assets.ingest.run.inputs:WorkerAnswers").modules
        assert "casa_assets.ingest.run.steps" in named_in_text

    def test_the_versions_of_a_validator_in_another_python_count(self, monkeypatch: pytest.MonkeyPatch) -> None:
        # A module that was merged into another took its name along unseen once, and the versions with it.
        assert {cache_key.CHECKS_OF_PLUGINS, cache_key.RULES_OF_SIMREADY} <= set(package_files().sources)
        monkeypatch.setattr(cache_key, "versions_elsewhere", lambda: {"simready-validate": "9.9"})
        assert reach("casa_assets.checks.package.usd").versions["simready-validate"] == "9.9"
        assert "simready-validate" not in reach("casa_assets.formats.usd.document").versions


class TestRegistry:
    def test_every_file_is_read_by_a_module_that_names_it(self) -> None:
        every = set(cache_key._registry())
        assert every == set(reach(*package_files().sources).registry)
        assert {p.name for p in registry.data_root().glob("*.yaml")} <= every

    def test_files_that_are_opened_are_among_those_that_count(self) -> None:
        """What a run of the doors opens, as Python itself tells it."""
        script = """
import sys, json
opened = []
sys.addaudithook(lambda event, args: opened.append(str(args[0])) if event == "open" else None)
from casa_assets.textures.run.recipes import recipes
from casa_assets.registry.families import families
from casa_assets.registry.kitchens import load_plan, load_style, plan_names, style_names
recipes(), families(), [load_plan(n) for n in plan_names()], [load_style(n) for n in style_names()]
from casa_assets.cache.cache_key import reach
from casa_assets import registry
doors = ("casa_assets.textures.run.recipes", "casa_assets.registry.families", "casa_assets.registry.kitchens")
root = str(registry.data_root())
print(json.dumps([sorted({o[len(root) + 1:] for o in opened if o.startswith(root)}), reach(*doors).registry]))
"""
        done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
        opened, counted = json.loads(done.stdout)
        assert set(opened) <= set(counted)
        assert len(opened) > 50


def _imports(tree: ast.Module) -> set[str]:
    """Modules that a tree imports, without those for types."""
    found = set()
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {target(node.module or "", alias.name) for alias in node.names}
        waiting += ast.iter_child_nodes(node)
    return found
