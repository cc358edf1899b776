"""Read files of an untrusted folder: regular ones inside its root only, and no more bytes than allowed."""

from __future__ import annotations

import os
import posixpath
import stat
from pathlib import Path

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable


def utf8_escaped(path: str) -> str:
    """Escape a path for messages and records: names that are not UTF-8 become text."""
    return path if path.isascii() else path.encode("utf-8", "backslashreplace").decode("utf-8")


def is_inside(path: str, root: Path) -> bool:
    """True where the real place of `path`, links followed, lies under the real place of `root`."""
    real, base = os.path.realpath(path), os.path.realpath(root)
    return real == base or real.startswith(base.rstrip(os.sep) + os.sep)


def check_file(path: str, root: Path) -> os.stat_result:
    """Stat of a regular, readable file inside the root; it is not opened.

    Raises:
        Rejected: MISSING_FILE, LINK_OUTSIDE, NOT_A_FILE, UNREADABLE.
    """
    name = printable(posixpath.basename(utf8_escaped(path)))
    is_link = False
    try:
        # Not the state of what a link leads to: a link that takes the place of a file later has another inode, which
        # `read_file` tells. Path would take longer than all the rest.
        found = os.lstat(path)
        is_link = stat.S_ISLNK(found.st_mode)
        if is_link and not is_inside(path, root):
            raise Rejected(codes.LINK_OUTSIDE, f"{name}: a link that leaves its package; put the file itself there")
        if is_link:
            found = os.stat(path)  # noqa: PTH116
    except (FileNotFoundError, NotADirectoryError) as error:
        if is_link:
            raise Rejected(codes.NOT_A_FILE, f"{name}: a link to nothing; put the file itself there") from error
        raise Rejected(codes.MISSING_FILE, f"{name}: there is no such file; add it or fix the name") from error
    except OSError as error:
        message = f"{name}: cannot be looked at ({error.strerror}); put a regular file there"
        code = codes.UNREADABLE if isinstance(error, PermissionError) else codes.NOT_A_FILE
        raise Rejected(code, message) from error
    except ValueError as error:
        raise Rejected(codes.BAD_NAME, f"{name}: a name that no file can have; fix it") from error
    if (is_link or os.path.dirname(path) != str(root)) and not is_inside(path, root):  # noqa: PTH120
        raise Rejected(codes.LINK_OUTSIDE, f"{name}: behind a link that leaves its package; put the file itself there")
    if not stat.S_ISREG(found.st_mode):
        kind = "a folder" if stat.S_ISDIR(found.st_mode) else "a pipe, socket or device"
        raise Rejected(codes.NOT_A_FILE, f"{name}: {kind}, not a regular file; put the file itself there")
    if not os.access(path, os.R_OK):
        raise Rejected(codes.UNREADABLE, f"{name}: may not be read; change its permissions")
    return found


def read_file(path: str, root: Path, max_bytes: float) -> bytes:
    """Bytes of a regular file inside the root.

    Raises:
        Rejected: as `check_file`, and TOO_LARGE before anything is read.
    """
    name = printable(Path(utf8_escaped(path)).name)
    checked = check_file(path, root)
    size = checked.st_size
    if size > max_bytes:
        message = f"{name}: {size} bytes, more than the {max(0, int(max_bytes))} left of --max-size; simplify it first"
        raise Rejected(codes.TOO_LARGE, message)
    try:
        # never blocks: what was a file at the check may be a pipe by now
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(handle, "rb") as stream:
            opened = os.fstat(handle)
            if not stat.S_ISREG(opened.st_mode):
                raise Rejected(codes.NOT_A_FILE, f"{name}: no longer a regular file")
            # A link that was put in its place meanwhile would lead anywhere.
            if (opened.st_dev, opened.st_ino) != (checked.st_dev, checked.st_ino):
                raise Rejected(codes.UNREADABLE, f"{name}: was exchanged while it was being opened; run again")
            return stream.read(size)
    except OSError as error:
        raise Rejected(codes.UNREADABLE, f"{name}: cannot be read ({error.strerror}); check the disk") from error
