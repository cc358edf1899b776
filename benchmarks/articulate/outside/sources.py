"""The public repositories that objects are built from, by name and commit, and their files."""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

import yaml

# Chosen before any object was scored, so that both halves are about as large and hold models of PartNet-Mobility.
SALT = 248
LIST = Path(__file__).with_name("sources.yaml")
# What objects are made of; pictures are not needed.
SUFFIXES = frozenset(
    [
        ".urdf",
        ".sdf",
        ".world",
        ".xml",
        ".xacro",
        ".usd",
        ".usda",
        ".usdc",
        ".obj",
        ".mtl",
        ".stl",
        ".dae",
        ".gltf",
        ".glb",
        ".bin",
        ".ply",
        ".off",
        ".msh",
        ".config",
    ]
)


@dataclass(frozen=True)
class ObjectSource:
    """One object of a repository.

    Attributes:
        file: that states its joints. root: link that is its root, where the file holds more; empty for all.
        types, pose, still: see `build_case` and `with_closed_pose`. without: regular expression of links to leave out,
            where the file holds several versions in one place. incomplete: some of its meshes are not published.
    """

    name: str
    origin: str
    repo: str
    commit: str
    licence: str
    file: str
    kind: str
    root: str = ""
    types: Mapping[str, str] = field(default_factory=dict)
    pose: Mapping[str, float] = field(default_factory=dict)
    incomplete: bool = False
    still: str = ""
    without: str = ""

    @property
    def is_sealed(self) -> bool:
        """True for objects of the origins that nobody looks at."""
        return is_sealed(self.origin)


def is_sealed(origin: str) -> bool:
    """Return whether an origin is of the sealed half, which its name decides."""
    return hashlib.sha256(f"{SALT}/{origin}".encode()).digest()[0] % 2 == 1


def objects() -> list[ObjectSource]:
    """Return all objects of sources.yaml."""
    out = []
    for origin in yaml.safe_load(LIST.read_text(encoding="utf-8")):
        shared = {key: origin[key] for key in ("origin", "repo", "commit", "licence")}
        common = origin.get("types", {})
        for row in origin["objects"]:
            stem = row.get("name") or "_".join(
                [*PurePosixPath(row["file"]).with_suffix("").parts[-2:], row.get("root", "")]
            )
            name = (
                "".join(c if c.isalnum() else "_" for c in f"{origin['repo'].split('/')[0]}_{stem}").strip("_").lower()
            )
            types = {**common, **row.get("types", {})}
            more: dict[str, Any] = {
                key: row[key]
                for key in ("file", "kind", "root", "pose", "incomplete", "still", "without")
                if key in row
            }
            out.append(ObjectSource(name=name, types=types, **shared, **more))
    doubled = {o.name for o in out if sum(p.name == o.name for p in out) > 1}
    if doubled:
        raise ValueError(f"{LIST.name}: two objects are named {', '.join(sorted(doubled))}; give each a `name`")
    return out


def checkout(repo: str, commit: str, folder: Path, mirror: Path | None) -> Path:
    """Return a folder with the files of a repository at a commit that objects may need, made where it is missing.

    Args:
        folder: to make it in.
        mirror: folder of git directories `owner+name`, or of folders `owner+name.files`; None to clone.
    """
    # Some repositories are taken at two commits.
    place = folder / f"{repo.replace('/', '+')}@{commit[:8]}"
    plain = None if mirror is None else mirror / f"{repo.replace('/', '+')}.files"
    if plain is not None and plain.is_dir():
        return plain
    done = place / ".commit"
    if done.is_file():
        return place
    git = _git_folder(repo, commit, folder, mirror)
    place.mkdir(parents=True, exist_ok=True)
    wanted = [(path, name) for path, name in _blobs(git, commit) if PurePosixPath(path).suffix.lower() in SUFFIXES]
    with subprocess.Popen(
        ["git", f"--git-dir={git}", "cat-file", "--batch"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as ran:
        assert ran.stdin
        assert ran.stdout
        for path, name in wanted:
            ran.stdin.write(f"{name}\n".encode())
            ran.stdin.flush()
            head = ran.stdout.readline().split()
            if len(head) < 3:
                continue  # the copy lacks it
            data = ran.stdout.read(int(head[2]) + 1)[:-1]
            target = place / path
            if place.resolve() not in target.resolve().parents:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
    done.write_text(commit)
    return place


def _git_folder(repo: str, commit: str, folder: Path, mirror: Path | None) -> Path:
    """Return the git directory of a repository that has a commit."""
    if mirror is not None:
        for place in sorted(mirror.glob(f"{repo.replace('/', '+')}*")):
            for head in sorted(place.rglob("HEAD")):
                if (head.parent / "objects").is_dir():
                    return head.parent
        raise FileNotFoundError(f"{mirror} has no copy of {repo}")
    place = folder / f"{repo.replace('/', '+')}.git"
    if not (place / "HEAD").is_file():
        subprocess.run(["git", "init", "-q", "--bare", place], check=True)
    url = f"https://github.com/{repo}"
    subprocess.run(["git", f"--git-dir={place}", "fetch", "-q", "--depth", "1", url, commit], check=True)
    return place


def _blobs(git: Path, commit: str) -> Iterator[tuple[str, str]]:
    """Yield the path and the name of each file of a commit."""
    tree = subprocess.run(
        ["git", f"--git-dir={git}", "ls-tree", "-r", "-z", commit], check=True, stdout=subprocess.PIPE
    ).stdout
    for row in tree.split(b"\0"):
        if row:
            about, path = row.split(b"\t", 1)
            mode, kind, name = about.split()
            if kind == b"blob" and mode != b"120000":
                yield path.decode("utf-8", "surrogateescape"), name.decode()
