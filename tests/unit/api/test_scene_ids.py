"""What load_scene takes for a kitchen: ids as `scenes new` prints them, and a seed beside an id that has none."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

import casa_assets as casa
from casa_assets.api import kitchen as module

ID = "one_wall_small__coastal"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Ids of the scenes that are looked for; none is built."""
    ids: list[str] = []

    def found(scene: str | Path, *_: object) -> tuple[Path, dict[str, list[str]]]:
        ids.append(str(scene))
        return Path("scene.xml"), {}

    monkeypatch.setattr(module, "_found", found)
    monkeypatch.setattr(module, "model_of", lambda source, sleep: mujoco.MjModel.from_xml_string("<mujoco/>"))
    return ids


def test_a_seed_stands_in_the_id(asked: list[str]) -> None:
    casa.load_scene(ID)
    casa.load_scene(ID, seed=3)
    casa.load_scene(f"{ID}__s3", seed=3)
    casa.load_scene(f"{ID}__closed__o40", seed=0)
    assert asked == [ID, f"{ID}__s3", f"{ID}__s3", f"{ID}__s0__closed__o40"]


@pytest.mark.usefixtures("asked")
def test_two_seeds_and_a_seed_of_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(casa.CasaError, match="has the seed 3"):
        casa.load_scene(f"{ID}__s3", seed=4)
    with pytest.raises(casa.CasaError, match="is a path"):
        casa.load_scene(tmp_path, seed=4)
