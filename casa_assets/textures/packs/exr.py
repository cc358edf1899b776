"""Read EXR files: the header here, the pixels by OpenEXR in a child process, which a broken file may end.

Run as a program (`python -m casa_assets.textures.packs.exr CHANNEL...`) it reads an EXR file from standard input and
writes these channels to standard output, as floats of 4 bytes. `read_pixels` is the parent's side. Ref: OpenEXR File
Layout, version 2.
"""

from __future__ import annotations

import io
import math
import os
import resource
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.process_limits import lower_limit
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error

MAGIC, SUFFIX = b"v/1\x01", ".exr"
MODULE, EXTRA = "OpenEXR", "exr"  # what reads the pixels, and the extra that brings it
# Limits of the child; choices. The largest picture that is read takes 3 GB and half a minute.
MEMORY_BYTES, CPU_S = 6_000_000_000, 120
# Bits of the version field.
_DEEP, _SEVERAL_PARTS = 0x800, 0x1000
_HALF, _FLOAT = 1, 2
_MAX_NAME = 255
_FLOATS = np.dtype("<f4")  # between the two processes
_COLOURS, _ALPHA = ("R", "G", "B"), "A"


@dataclass(frozen=True)
class ExrHeader:
    """Size and channels of an EXR file.

    Attributes:
        width, height: pixels. channels: in the order in which they are read: colours, or one of any name; then alpha.
    """

    width: int
    height: int
    channels: tuple[str, ...]

    @property
    def has_alpha(self) -> bool:
        """True if the last channel tells how much can be seen through."""
        return self.channels[-1] == _ALPHA and len(self.channels) > 1


def read_header(data: bytes) -> ExrHeader:
    """Size and channels of an EXR file; no pixel is unpacked.

    Raises:
        Rejected: it is cut or garbled, or has several parts, depths, or other channels than a texture has.
    """
    try:
        found = _header(data)
    except (struct.error, ValueError, KeyError, IndexError):
        raise rejection_error(PictureRejection.BROKEN, "cannot be decoded: its EXR header is cut or garbled") from None
    return found


def _header(data: bytes) -> ExrHeader:
    if not data.startswith(MAGIC):
        raise ValueError
    (version,) = struct.unpack_from("<I", data, 4)
    if version & (_DEEP | _SEVERAL_PARTS):
        raise rejection_error(PictureRejection.NOT_A_PICTURE, "is an EXR file with several parts, or with depths")
    attributes = dict(_attributes(data, 8))
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    return ExrHeader(right - left + 1, bottom - top + 1, _ordered(list(_channels(attributes["channels"]))))


def _attributes(data: bytes, at: int) -> Iterator[tuple[str, bytes]]:
    """Names and values of a header. Raises ValueError, struct.error."""
    while data[at] != 0:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        value = data[at + 4 : at + 4 + size]
        if size < 0 or len(value) != size:
            raise ValueError(name)
        at += 4 + size
        yield name, value


def _channels(value: bytes) -> Iterator[str]:
    """Names of channels. Raises Rejected where one has integers or fewer pixels than the picture."""
    at = 0
    while value[at] != 0:
        name, at = _text(value, at)
        kind, _, across, down = struct.unpack_from("<4i", value, at)
        if kind not in (_HALF, _FLOAT) or (across, down) != (1, 1):
            message = f"is an EXR file whose channel {name} holds no half or float for each pixel"
            raise rejection_error(PictureRejection.NOT_A_PICTURE, message)
        at += 16
        yield name


def _ordered(names: list[str]) -> tuple[str, ...]:
    """The channels in their order. Raises Rejected where they are neither colours nor one alone."""
    shown = [name for name in names if name != _ALPHA or len(names) == 1]
    alpha = (_ALPHA,) * (len(names) - len(shown))
    if len(shown) == 1:
        return (*shown, *alpha)
    if sorted(shown) != sorted(_COLOURS):
        told = ", ".join(sorted(names)[:8])
        message = f"is an EXR file with the channels {told}; R, G and B, or one alone are read"
        raise rejection_error(PictureRejection.NOT_A_PICTURE, message)
    return (*_COLOURS, *alpha)


def _text(data: bytes, at: int) -> tuple[str, int]:
    """A text that ends with a zero, and what comes behind it. Raises ValueError."""
    end = data.index(b"\0", at, at + _MAX_NAME + 1)
    return data[at:end].decode("utf-8"), end + 1


def read_pixels(data: bytes, header: ExrHeader) -> npt.NDArray[np.float32]:
    """(H, W, channels) as the file has them: linear light, or the numbers of a map.

    Args:
        header: of the same bytes, its size within bounds.
    Raises:
        Rejected: they cannot be unpacked within the limits of the child.
    """
    command = [sys.executable, "-m", "casa_assets.textures.packs.exr", *header.channels]
    done = subprocess.run(command, input=data, capture_output=True, check=False)
    shape = (header.height, header.width, len(header.channels))
    if done.returncode == 0 and len(done.stdout) == math.prod(shape) * _FLOATS.itemsize:
        return np.frombuffer(done.stdout, dtype=_FLOATS).reshape(shape).astype(np.float32, copy=False)
    words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:] or [f"it ended with {done.returncode}"]
    raise rejection_error(PictureRejection.BROKEN, f"cannot be decoded: OpenEXR: {words[0][:200]}")


def main() -> int:
    """The child: limits itself, reads, unpacks, writes."""
    data, names = sys.stdin.buffer.read(), sys.argv[1:]
    for kind, amount in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_CPU, CPU_S),
        (resource.RLIMIT_AS, MEMORY_BYTES),
    ):
        lower_limit(kind, amount, amount)
    # OpenEXR prints to standard output, so that is sent to standard error and the pipe is kept for the answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    import OpenEXR

    with OpenEXR.File(io.BytesIO(data), separate_channels=True) as file:
        found = file.channels()
        planes = np.stack([found[name].pixels for name in names], axis=2)
    with os.fdopen(answer, "wb") as out:
        out.write(planes.astype(_FLOATS).tobytes())
    return 0


if __name__ == "__main__":
    sys.exit(main())
