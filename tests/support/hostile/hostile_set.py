"""The shared set of defective and hostile inputs: given to the program, and held row by row against its index.

The index says in words what should become of each file. Those words are mapped to codes here and nowhere else.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.formats.read.formats import SUFFIXES, suffix_of
from casa_assets.ingest.sources.places import TWINS as OTHER_FORMS
from casa_assets.ingest.sources.places import kind_of_other
from tests.support.library.libraries import casa, input_rows

# Words of the index for a reason to reject -> codes; where there are none, the code whose name is that word.
REASONS: Mapping[str, tuple[str, ...]] = {
    "bad_manifest": ("MAN001", "MAN002"),
    "degenerate": ("MSH001", "MSH002", "MSH004", "GEO001", "VIS001"),
    "flat": ("MSH002", "MSH004", "FLT004"),
    "multi_object": ("MSH024", "FLT005"),
    "off_category": ("FLT007", "FLT008"),
    "scale_unknown": ("MSH003",),
    "precision_lost": ("MSH001",),
    "image_bomb": ("SRC047",),
}
# Words of the index for a repair or a warning -> codes of which one has to be among the warnings. SILENT: what is asked
# for is plain in the result (a good pose, no unused vertex), or loses nothing and is done without a word. Those without
# codes are things that are not done here.
SILENT: tuple[str, ...] | None = None
REMARKS: Mapping[str, tuple[str, ...] | None] = {
    words: tuple(codes.split()) if codes != "silent" else SILENT
    for codes, every in {
        "silent": "BOM|image converted|name sanitised|recentred|sheared|stood upright|unit/up axis converted|"
        "unused vertex removed|vertices merged",
        "": "DTD not loaded|decompressed under a size limit|entity not expanded|extreme aspect",
        "SRC056": "animation ignored|skin ignored",
        "SRC053": "bad colours dropped",
        "MAN002": "bad entries skipped and listed|bad rows skipped and listed",
        "SRC052 MSH010": "bad face dropped, with warning|face dropped, with warning",
        "SRC061": "bad material value",
        "SRC050": "bad uv|NaN uv set to 0, with warning",
        "SRC052 SRC061 SRC054": "bad values dropped, with warning",
        "SRC052 SRC061 SRC054 MAN005": "bad values ignored",
        "SRC059": "base colour alpha",
        "SRC044": "case mismatch",
        "REV001 FLT007": "category unknown",
        "SRC060": "concave face triangulated as a fan",
        "MSH013": "crumbs removed, with warning|floater removed, with warning",
        "MSH010": "degenerate faces removed|duplicate faces removed|reversed duplicates removed",
        "SRC055": "directives ignored",
        "MSH010 MSH023 MSH046": "fin removed",
        "SRC059 MSH018": "fully transparent|opaque",
        "MSH012": "ground plane removed, with warning|sky sphere removed, with warning",
        "SRC005": "header length ignored",
        "MSH042 MSH043": "hidden interior",
        "SRC058": "identity, with warning",
        "MSH042": "interior removed",
        "SRC046": "link out of the package not followed",
        "MSH024 MSH013": "many components",
        "SRC042 SRC065": "material missing",
        "SRC057": "mesh not in the scene used",
        "RUN007": "near duplicate",
        "MSH023": "non-manifold",
        "SRC054": "normals recomputed",
        "MSH022": "not watertight|open shell",
        "FLT007 FLT008 REV001": "off_category",
        "REV001": "pose",
        "SRC066": "recentred, precision lost",
        "SRC041": "reference outside the package ignored",
        "MSH014": "rescaled by category",
        "MSH050": "self-intersecting",
        "MSH024": "several objects",
        "FLT008 FLT009": "shape does not fit category",
        "SRC049": "texture downscaled",
        "SRC047 SRC048": "texture dropped",
        "SRC043": "texture found by its base name",
        "SRC042": "texture missing|texture missing, base colour used",
        "SRC047": "texture refused (too large)",
        "SRC048": "texture unreadable",
        "SRC051 MSH017": "texture without uv",
        "MSH028": "thickened",
        "SRC040": "type by content, not by name",
        "MSH011": "winding flipped|winding made consistent",
    }.items()
    for words in every.split("|")
}
TWINS = ("RUN006", "RUN007")
# Files of which we expect something else than the index does: how what is said of them begins, and why.
DISPUTED: dict[str, tuple[str, str]] = {
    "files/g_inside_out.glb": (
        "accepted",
        "its signed volume is +120 cm^3: it is the only one that faces outwards; the control, at -120 cm^3, is turned",
    ),
    "files/m_missing_fields.jsonl": ("accepted", "the name of the file says that it is a mug"),
    "files/r_trimesh/busted.STL": ("accepted", "each of its 5817 edges has two faces: it is watertight as it stands"),
    "files/r_trimesh/two_objects.obj": (
        "accepted",
        "a tetrahedron in a corner of a cube, sharing its edges: one solid body, remarked as no manifold (MSH023)",
    ),
    "files/r_trimesh/notenoughindices.obj": (
        "rejected MSH002",
        "without the bad face one triangle is left, which is flat",
    ),
}


@dataclass(frozen=True)
class Said:
    """What the program said of one input: a line of `ingest --json`."""

    path: str
    accepted: bool
    code: str
    message: str
    warnings: tuple[str, ...]
    asset_id: str

    @classmethod
    def of(cls, line: Mapping[str, Any]) -> Said:
        codes, accepted = tuple(w["code"] for w in line["warnings"]), line["status"] in ("accepted", "review")
        return cls(line["path"], accepted, line["code"], line["message"], codes, line["id"])


@dataclass(frozen=True)
class Row:
    """A row of the index.

    `file`: relative to the set. `wanted`: the outcome it expects, then the others that are right. `kind`: its class.
    """

    file: str
    wanted: tuple[str, ...]
    kind: str

    @property
    def path(self) -> str:
        """Relative to the folder `files`, as the program names it."""
        return self.file.removeprefix("files/")


def rows_of(folder: Path) -> list[Row]:
    data = json.loads((folder / "index.json").read_text(encoding="utf-8"))
    return [Row(r["file"], (r["expected"], *r["alt_ok"]), r["cls"]) for r in data]


def fits(said: Said, words: str) -> bool:
    """Whether one outcome is what the words of the index ask for."""
    if said.code.startswith("RUN") and said.code not in TWINS:
        return False  # a crash, a hang or a bug is never what was expected
    verb, _, rest = words.partition(":")
    rest = rest.strip()
    if verb == "reject":
        if rest.startswith("duplicate of"):
            return said.code in TWINS and rest.split()[-1] in said.message
        named = [code for code, row in registry.load().rejections.items() if row.name == rest]
        return not said.accepted and (rest == "*" or said.code in REASONS.get(rest, named))
    if not said.accepted:
        return False
    if verb == "accept":
        return True
    codes = REMARKS[rest]
    return codes is SILENT or bool(set(codes) & set(said.warnings))


def verdict(row: Row, said: Sequence[Said]) -> str:
    """Empty where the row ended as its index says, else what was said of it."""
    if not said:
        return "nothing was said of it"
    if any(one.code.startswith("RUN") and one.code not in TWINS for one in said):
        return "; ".join(map(told, said))
    if any(fits(one, words) for words in row.wanted for one in said):
        return ""
    # A manifest whose good rows were taken while the bad ones are refused one by one.
    skips = any("skipped and listed" in words for words in row.wanted) and any(one.accepted for one in said)
    if skips and {one.code for one in said if not one.accepted} == {"MAN002"}:
        return ""
    return "; ".join(map(told, said))


def disputed(row: Row, message: str) -> str:
    """Why what became of a row is right although its index says otherwise; empty where there is no such reason."""
    begins, why = DISPUTED.get(row.file, ("?", ""))
    return why if message.startswith(begins) else ""


def told(said: Said) -> str:
    """One outcome in one line."""
    if said.accepted:
        return f"accepted, warnings {sorted(set(said.warnings))}"
    return f"rejected {said.code}: {said.message.splitlines()[0][:160]}"


class HostileSet:
    """The set under a folder of our own, completed with links and odd names, and libraries made of it.

    `shared`: the folder `bad`. `work`: an empty folder. `options`: of every run of `ingest`. `environment`: of every
    run.
    """

    def __init__(self, shared: Path, work: Path, options: Sequence[str], environment: Mapping[str, str]) -> None:
        self.root, self.work = work / "set", work
        self._options, self._environment = options, dict(environment)
        subprocess.run(["bash", str(shared / "make_special.sh"), str(self.root)], check=True)
        self.rows = rows_of(self.root)
        self.said: dict[str, list[Said]] = {}
        self.codes: dict[str, int] = {}
        self._runs = 0

    def run(self) -> None:
        """All rows: those that a folder holds together at once, manifests and the like one by one.

        What was taken for a copy of another row's mesh goes in again without that one, until each had its own verdict.
        """
        alone = [row for row in self.rows if self.is_alone(row)]
        copies = [row for row in self.rows if row.kind == "duplicate"]
        others = [row for row in self.rows if row not in alone and row not in copies]
        self._together("together", others, "--keep-duplicates")
        self._together("copies", copies)
        for row in alone:
            self.said[row.file] = self._ingest(self.root / row.file)
        left, turn = len(self.rows), 0
        while again := [row for row in others if any(one.code in TWINS for one in self.said.get(row.file, []))]:
            if len(again) == left:
                break  # each of these is a copy of what it holds itself
            left, turn = len(again), turn + 1
            for row in again:
                del self.said[row.file]
            self._together(f"again_{turn}", again, "--keep-duplicates")

    def special(self) -> list[Said]:
        """The folder of pipes, devices, loops of links and a sparse file."""
        return self._ingest(self.root / "special")

    def libraries(self) -> Iterator[Path]:
        yield from sorted(self.work.glob("library_*"))

    def is_alone(self, row: Row) -> bool:
        """A manifest takes meshes that have rows of their own; what is not called a mesh has to be named.

        So has another form of a mesh that lies beside it: in its folder it is counted and not read.
        """
        folder = (self.root / row.file).parent
        names = frozenset(path.name.lower() for path in folder.iterdir()) if folder.is_dir() else frozenset()
        is_other = kind_of_other(Path(row.path).name, names) == OTHER_FORMS
        return is_other or suffix_of(row.path) not in SUFFIXES

    def _together(self, name: str, rows: Iterable[Row], *options: str) -> None:
        kept = {row.path: row.file for row in rows}
        folder = self.work / name
        shutil.copytree(self.root / "files", folder, symlinks=True)
        others = {row.path for row in self.rows} - set(kept)
        for path in sorted(others, key=len, reverse=True):
            place = folder / path
            if place.is_dir() and not place.is_symlink():
                shutil.rmtree(place)
            else:
                place.unlink()
        for one in self._ingest(folder, *options):
            if one.path in kept:
                self.said.setdefault(kept[one.path], []).append(one)

    def _ingest(self, source: Path, *options: str) -> list[Said]:
        self._runs += 1
        library = self.work / f"library_{self._runs:03d}"
        done = casa("ingest", source, "--library", library, "--json", *self._options, *options, **self._environment)
        self.codes[os.fsdecode(os.fsencode(source.name))] = done.returncode
        assert done.returncode in (0, 1, 4), (source.name, done.returncode, done.stderr[-2000:])
        return [Said.of(row) for row in input_rows(done.stdout)]
