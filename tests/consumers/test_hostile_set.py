"""The shared set of defective and hostile inputs, row by row against its index, through the whole of `ingest`."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path

import pytest

from tests.support.hostile.access_audit import Watch
from tests.support.hostile.hostile_set import TWINS, HostileSet, Row, Said, disputed, told, verdict
from tests.support.library.libraries import casa, input_rows, ran

pytestmark = pytest.mark.certify

BAD = Path(os.environ.get("CASA_SHARED", "../shared")) / "data" / "bad"
# What a worker may use here: a bomb that goes off dies of it and is told, with a code that no row expects.
OPTIONS = ("--memory", "2", "--timeout", "1200")
PARENT_BYTES = 600_000_000
SAFE = re.compile(r"[A-Za-z0-9_.-]+")
NOT_A_NUMBER = re.compile(rb"(?<![\w.])[-+]?(nan|inf|infinity)(?![\w.])", re.IGNORECASE)


@pytest.fixture(scope="module")
def watch(tmp_path_factory: pytest.TempPathFactory) -> Watch:
    return Watch(tmp_path_factory.mktemp("watch"))


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory, watch: Watch) -> HostileSet:
    assert BAD.is_dir(), f"{BAD} is missing; set CASA_SHARED"
    made = HostileSet(BAD, tmp_path_factory.mktemp("bad"), OPTIONS, watch.environment)
    made.run()
    return made


@pytest.fixture(scope="module")
def special(hostile: HostileSet) -> dict[str, Said]:
    return {one.path: one for one in hostile.special()}


def wrong(row: Row, said: list[Said]) -> dict[str, str]:
    message = verdict(row, said)
    return {row.file: f"wanted {' | '.join(row.wanted)}; {message}"} if message and not disputed(row, message) else {}


def test_every_row_ends_as_its_index_says(hostile: HostileSet) -> None:
    assert len(hostile.rows) > 200
    assert [found for row in hostile.rows if (found := wrong(row, hostile.said.get(row.file, [])))] == []
    # What the dispute about `g_inside_out.glb` rests on: the control faces inwards, and the one inside out does not.
    (control,), (inside_out,) = (hostile.said[f"files/{n}.glb"] for n in ("00_control_good_mug", "g_inside_out"))
    assert "MSH011" in control.warnings
    assert "MSH011" not in inside_out.warnings


def test_special_files_are_refused_without_being_read(special: dict[str, Said]) -> None:
    no_file = {"s_pipe.obj": {"SRC019"}, "s_empty_dir.glb": {"SRC019"}, "s_dev_zero.stl": {"SRC018", "SRC019"}}
    wanted = no_file | {"s_sparse_20g.glb": {"SRC015"}}
    for name, codes in wanted.items():
        assert special[name].code in codes, told(special[name])
    names = [name for name in special if name.startswith("s_bad_utf8")]
    assert [special[name].code for name in names] in (["SRC028"], ["SRC004"])
    assert not [name for name in special if name.startswith("s_loop_dir")]


def test_nobody_goes_beyond_the_folders_and_the_parent_stays_small(
    hostile: HostileSet, special: object, watch: Watch
) -> None:
    assert watch.escapes([hostile.work], list(hostile.libraries())) == []
    peaks = watch.peaks("casa_assets/cli/main.py")
    assert len(peaks) >= len(hostile.codes)
    assert max(peaks) < PARENT_BYTES


def test_outputs_have_safe_names_no_number_is_missing_and_nothing_of_the_machine_is_told(hostile: HostileSet) -> None:
    for library in hostile.libraries():
        names = {part for path in library.rglob("*") for part in path.relative_to(library).parts}
        assert not [name for name in names if not SAFE.fullmatch(name) or name.startswith("-")]
    assert not list(hostile.work.rglob("PWNED"))
    foreign = Path("/etc/passwd").read_bytes().splitlines()[0]
    written = (path for library in hostile.libraries() for path in sorted(library.rglob("*")) if path.is_file())
    for path in written:
        if path.suffix in (".xml", ".obj", ".usda", ".json", ".md", ".html"):
            data = path.read_bytes()
            assert path.suffix not in (".xml", ".obj", ".usda") or not NOT_A_NUMBER.search(data), path
            assert foreign not in data, path


def test_unit_and_axis_are_not_ignored_in_silence(hostile: HostileSet) -> None:
    """Inches with x up: a cube of 2.5 m is no object of a kitchen, and that it was rescaled is told."""
    paths = [path for library in hostile.libraries() for path in library.glob("*/*/asset.json")]
    found = {path.parent.name: json.loads(path.read_text(encoding="utf-8")) for path in paths}
    assert all(min(entry["certificate"]["summary"]["extents"]) > 0 for entry in found.values())
    (said,) = hostile.said["files/x_inch_x_up.dae"]
    entry = found[said.asset_id]
    reason = {guess["subject"]: guess["reason"] for guess in entry["asset"]["provenance"]["guesses"]}
    assert "states x up" in reason["up_axis"]
    assert "MSH014" in said.warnings


def test_two_million_faces_within_the_limits(tmp_path: Path, watch: Watch) -> None:
    mesh = tmp_path / "mug_2m_faces.stl"
    ran(sys.executable, BAD / "gen_2m_faces.py", mesh)
    done = casa("ingest", mesh, "--library", tmp_path / "library", "--json", **watch.environment)
    (said,) = [Said.of(row) for row in input_rows(done.stdout)]
    assert (said.accepted and "MSH015" in said.warnings) or said.code == "SRC015", told(said)


def test_the_whole_set_in_one_run_ends_as_any_other(hostile: HostileSet) -> None:
    """Links, odd names and rows that name other files are among it: each ends as its index says, or as a copy."""
    library = hostile.work / "library_at_once"
    done = casa("ingest", hostile.root / "files", "--library", library, "--json", "--jobs", 2, *OPTIONS)
    assert done.returncode in (0, 1), done.stderr[-2000:]
    assert "Traceback" not in done.stderr[-2000:]
    said = [Said.of(row) for row in input_rows(done.stdout)]
    assert not [told(one) for one in said if one.code.startswith("RUN") and one.code not in TWINS]
    of: dict[str, list[Said]] = {}
    for one in said:
        of.setdefault(one.path, []).append(one)
    rows = [row for row in hostile.rows if not hostile.is_alone(row)]
    of_twins = {one.path for one in said if one.code in TWINS}
    assert [found for row in rows if row.path not in of_twins and (found := wrong(row, of.get(row.path, [])))] == []
