"""Messages about slips: one line that says what is wrong and what would be right, and one with the help."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.errors import CasaError
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import called as casa


def test_wrong_use_is_one_line_and_the_place_of_the_help(subtests: pytest.Subtests) -> None:
    for words, message in [
        ("scenes new l_small --seed -3", "--seed: -3 is less than 0"),
        ("preview . --width-px 5000", "--width-px: 5000 is not from 64 to 4096"),
        ("scenes sample many", "COUNT: 'many' is no whole number"),
        ("scenes fit u_small --width wide --depth 2", "--width: 'wide' is no number"),
        ("textures list --set walls", "--set: 'walls' is none of wall, floor, counter, cabinet; did you mean wall?"),
        ("textures ingest . --tile -1 1 --library /dev/null/x", "--tile: "),
        ("scenes new", "PLAN is missing"),
        ("ingest", "SOURCES is missing"),
        ("ingest nowhere", "SOURCES: path 'nowhere' does not exist"),
        ("ingest . --library s3://bucket/library", "--library: s3:// is the address of a store"),
        ("ingest . --store /dev/null/store --dry-run", "--store: does not go with --dry-run"),
        ("report --libary x", "no such option: --libary; did you mean --library?"),
        ("ingst", "no such command 'ingst'; did you mean ingest"),
        ("schemas scene plan", "too many words: plan"),
        ("ingest . --engine local --address auto", "--address: is of a Ray cluster; add --engine ray"),
        ("find --library .", "QUERY: there are no words to look for"),
    ]:
        with subtests.test(words=words):
            done = CliRunner().invoke(app, words.split())
            assert (done.exit_code, done.stdout) == (2, "")
            first, second = done.stderr.splitlines()
            assert first.startswith(f"error: {message}")
            assert second.startswith("hint: casa-assets ")
            assert second.endswith(" --help")
    for words, message in [
        ("checks SCN999", "unknown code 'SCN999'; did you mean SCN"),
        ("view nothing", "unknown kitchen, asset or file 'nothing'; `casa-assets scenes list` and `casa-assets find`"),
        ("scenes new l_small --textures wall=brik", "unknown wall texture 'brik'; did you mean brick_"),
    ]:
        with subtests.test(words=words):
            error = CliRunner().invoke(app, words.split()).exception
            assert isinstance(error, CasaError)
            assert str(error).startswith(message)


def test_codes_of_reports_are_explained() -> None:
    done = CliRunner().invoke(app, ["checks", "usd002", "FLT005", "TEX001", "PCK010"])
    assert done.exit_code == 0, done.output
    first = [line for line in done.stdout.splitlines() if not line.startswith(" ")]
    assert [line.split()[0] for line in first] == ["USD002", "FLT005", "TEX001", "PCK010"]
    for words in ("SimReady profile", "error: what fails is kept out", "rejection: the input was not taken", "limit:"):
        assert words in done.stdout


NO_PLACE = "/dev/null/place"  # a path below a file that is no folder is refused for root as well


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    """Small inputs by the words that stand for them; nothing may appear in `empty` or `new`."""
    found = {name: tmp_path / name for name in ("empty", "taken", "new")} | {"file": tmp_path / "box.obj"}
    for name in ("empty", "taken"):
        found[name].mkdir()
    (found["taken"] / "a").touch()
    found["file"].write_text("v 0 0 0\n", encoding="ascii")
    found["mjcf"] = tmp_path / "robot.xml"
    found["mjcf"].write_text("<mujoco><worldbody/></mujoco>", encoding="utf-8")
    return {**found, "library": keep(tmp_path / "library", loose_and_fixed())}


def test_misuse_is_one_line_and_leaves_nothing(places: dict[str, Path], subtests: pytest.Subtests) -> None:
    for words, message in (
        (f"textures make oak_natural_plank --out {NO_PLACE} --width-px 64", "cannot be written to"),
        (f"families show microwave --preset stel --out {NO_PLACE}", "did you mean steel?"),
        ("report --library {empty}", "is no library"),
        ("report --library {empty} --out report.json", "name a file that ends in .html"),
        ("preview {file}", "is no MJCF"),
        ("preview {empty}", "no asset found"),
        ("view {mjcf} --web", "leave --web out"),
        ("articulate {empty}", "no mesh found"),
        ("articulate {file} --up sideways", "--up"),
        ("articulate {file} --decisions {empty}", "--decisions"),
        ("scenes preview l_small__coastal --out {empty}", "casa-assets scenes build l_small__coastal"),
        ("ingest {file} --category cuting_board --library {new}", "did you mean cutting_board"),
        (f"ingest {{file}} --library {NO_PLACE}", "cannot be written to"),
        ("find mug --library {library} --clip-weights nowhere.pt", "nowhere.pt: there are no weights of CLIP"),
        ("find mug --library {library} --where size=3", "size is compared with"),
        ("find mug --library {library} --clip-weights x --where size<3", "leave --clip-weights out"),
        ("find mug --library {empty}", "is no library"),
        ("export robocasa {empty} --out {new}", "holds no accepted asset"),
        ("export robocasa {library} --out {taken}", "neither empty nor an earlier export"),
        ("export robocasa {library} --out {new} --registry No", "no name of a registry"),
        ("export urdf --scenes l_smal__coastal --out {new}", "l_small__coastal"),
        ("export urdf {empty} --jobs 2 --out {new}", "holds no accepted asset"),
        ("library push {library} https://someone:secret@example.org/lib", "https://example.org/lib: is no store"),
        ("library push {library} simplecache::s3://bucket/lib", "is no store that can be written to"),
    ):
        with subtests.test(words):
            done = casa(*(word.format(**places) for word in words.split()))
            assert done.returncode == 2, done.stderr
            assert message in " ".join(done.stderr.split())
            assert not any(word in done.stderr for word in ("Traceback", "secret"))
            assert list(places["empty"].iterdir()) == []
            assert not (places["new"] / "assets").exists()


def test_what_is_optional_and_missing_is_named_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "library" / ".casa").mkdir(parents=True)
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pyarrow" else find_spec(name))
    words = ["library", "index", str(tmp_path / "library"), "--out", str(tmp_path / "tables")]
    error = CliRunner().invoke(app, words).exception
    assert isinstance(error, CasaError)
    assert all(word in str(error) for word in ("extra 'parquet'", "-m pip install"))
    assert not (tmp_path / "tables").exists()


def test_the_help_of_ingest_shows_the_limits_of_the_registry() -> None:
    command = typer.main.get_command(app).commands["ingest"]  # type: ignore[attr-defined]
    limits = {"timeout": "input_seconds", "memory": "input_memory_bytes", "max_size": "input_bytes"}
    limits |= {"max_faces": "input_faces", "max_texture": "input_texture_px", "max_pixels": "input_texture_pixels"}
    for option, limit in limits.items():
        found = re.search(r"; ([\d.]+) by default\.$", next(p.help for p in command.params if p.name == option))
        unit = {"memory": 1e9, "max_size": 1e6, "max_pixels": 1e6}.get(option, 1)
        assert float(found[1] if found else 0) == registry.load().limits[limit] / unit, option
