"""Which tests of other programs run after a change."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.consumers import watched

HERE = watched.HERE


def test_what_is_recorded_is_left_out_and_what_differs_is_run() -> None:
    keys = watched.present_keys()
    assert watched.changed(keys) == frozenset()
    other = {**keys, "test_urdf.py": "0", "docs/howto/use/glb.md": "0"}
    del other["test_clip.py"]
    assert watched.changed(other) == {"test_urdf.py", "docs/howto/use/glb.md", "test_clip.py"}
    assert watched.environments(["test_urdf.py", "docs/howto/use/glb.md"]) == sorted([*watched.ALWAYS, "urdf"])


def test_a_key_changes_with_what_is_watched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = tmp_path / "module.py"
    monkeypatch.setitem(watched.WATCHED, "test_urdf.py", watched.Watched(("urdf",), (str(tmp_path),)))
    keys = []
    for change in (
        lambda: module.write_text("x = 1\n"),
        lambda: module.write_text("x = 2\n"),
        lambda: module.rename(tmp_path / "other.py"),
        (tmp_path / "more.txt").touch,
    ):
        change()
        watched._digest.cache_clear()
        keys.append(watched.key_of("test_urdf.py"))
        watched._digest.cache_clear()
        assert watched.key_of("test_urdf.py") == keys[-1]
    assert len(set(keys)) == 4


def test_a_script_that_a_test_names_is_part_of_its_key() -> None:
    assert HERE / "clip_run.py" in watched._own(HERE / "test_clip.py")
    assert HERE.parent / "support" / "program" / "browser.py" in watched._own(HERE / "test_viewer.py")


def test_every_environment_of_another_program_is_stated() -> None:
    """A file that asks for an environment which is not there each time says so in WATCHED."""
    named = re.compile(r"\.venv-(\w+)")
    known = {path.stem for path in watched.ENVIRONMENTS.glob("*.txt")}
    for file in sorted(HERE.rglob("test_*.py")):
        own = watched._own(file)
        found = {name for path in own if path.suffix == ".py" for name in named.findall(path.read_text("utf-8"))}
        path = file.relative_to(HERE).as_posix()
        whole = re.search(r"^pytestmark = pytest.mark.certify$", file.read_text("utf-8"), re.MULTILINE)
        stated = set(watched.WATCHED[path].environments) if path in watched.WATCHED else set(watched.ALWAYS)
        assert whole or found & known <= stated, path
