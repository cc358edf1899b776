"""What people decided in review.csv and review.json, when a library is copied: no decision is lost unasked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from casa_assets.errors import OutputError
from casa_assets.pipeline.articulate import review_file
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library import review
from casa_assets.pipeline.library.remote.remote_library import RemoteLibrary

NAMES = (review.NAME, review_file.NAME)
Decided = Mapping[str, object]


def check_push(library: disk.Library, remote: RemoteLibrary) -> None:
    """Check that a push overwrites no decision. Raises OutputError where the store has one that the library lacks."""
    with _fetched(library, remote) as there:
        own, others = _decided(library), _decided(there)
    for name in NAMES:
        if lacking := [digest for digest, said in others[name].items() if own[name].get(digest) != said]:
            message = f"{name} there has decisions that {library.root} lacks, such as on {min(lacking)[:10]}"
            raise OutputError(remote.url, f"{message}; pull first, or overwrite them with --delete")


def take_over(library: disk.Library, remote: RemoteLibrary, is_overwritten: bool) -> None:
    """Take the decisions on the store over into a library; its own on other inputs stay.

    Args:
        is_overwritten: take the files of the store as they are, whatever was decided here.
    Raises:
        OutputError: both decide differently about an input; nothing is changed then.
    """
    with _fetched(library, remote) as there:
        own, others = _decided(library), _decided(there)
        for name in NAMES if not is_overwritten else ():
            if differing := [d for d in own[name].keys() & others[name].keys() if own[name][d] != others[name][d]]:
                message = f"{name} decides otherwise on {min(differing)[:10]} than {library.root / name}"
                raise OutputError(remote.url, f"{message}; change one, or take those of the store with --delete")
        for name in NAMES:
            if is_overwritten or own[name].keys() <= others[name].keys():
                _replace(library.root / name, there.root / name)
        if not is_overwritten:
            review.adopt(library, [there])
            review_file.keep(library, review_file.decided(there))


def _decided(library: disk.Library) -> dict[str, Decided]:
    """What was decided, by the name of the file, then by the digest of the input."""
    return {
        review.NAME: review.read_overrides(library),
        review_file.NAME: review_file.decided(library),
    }


@contextmanager
def _fetched(library: disk.Library, remote: RemoteLibrary) -> Iterator[disk.Library]:
    """A folder with the files of the store, as far as it has them."""
    with TemporaryDirectory(dir=library.private, prefix="decisions.") as folder:
        for name in NAMES:
            if (data := remote.folder.read(name)) is not None:
                (Path(folder) / name).write_bytes(data)
        yield disk.Library(Path(folder))


def _replace(target: Path, source: Path) -> None:
    if source.exists():
        source.replace(target)
    else:
        target.unlink(missing_ok=True)
