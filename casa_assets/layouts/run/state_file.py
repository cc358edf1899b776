"""Start states of a scene as one file, `start_states.npz`: a header of JSON and four arrays, nothing pickled."""

from __future__ import annotations

import hashlib
import io
import json
import shlex
import zipfile
import zlib
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from casa_assets.core.system import replace_file
from casa_assets.errors import CasaError
from casa_assets.model.kitchen.files import START_STATES
from casa_assets.model.kitchen.scene import ARRAYS, StartStates

LARGEST_BYTES = 1 << 28  # more than any kitchen's states take
_DAMAGED = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error, ValidationError)


def write_states(folder: Path, states: StartStates) -> Path:
    """Write the file into the folder of its scene, by one rename; the same states are the same bytes."""
    text = json.dumps(states.header, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    stream = io.BytesIO()
    arrays = {name: getattr(states, name).astype("<f4") for name in ARRAYS}
    header = np.frombuffer(text.encode("ascii"), dtype=np.uint8)
    np.savez_compressed(stream, allow_pickle=False, header=header, **arrays)
    return replace_file(folder / START_STATES, stream.getvalue())


def read_states(folder: Path) -> StartStates:
    """Return the start states in the folder of a scene. Raises CasaError if they are missing or damaged."""
    path = folder / START_STATES
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(member.file_size for member in archive.infolist())
        if size > LARGEST_BYTES:
            raise ValueError(f"it holds {size} bytes, more than {LARGEST_BYTES}")
        with np.load(path, allow_pickle=False) as found:
            header = json.loads(found["header"].tobytes())
            return StartStates.model_validate({**header, **{name: found[name] for name in ARRAYS}})
    except FileNotFoundError:
        raise CasaError(
            f"{path}: there are no start states; casa-assets scenes states {folder.name} makes them"
        ) from None
    except _DAMAGED as error:
        if isinstance(error, ValidationError):
            first = error.errors()[0]
            why = f"{'.'.join(map(str, first['loc'])) or 'all of it'}: {first['msg']}"
        else:
            why = (str(error) or type(error).__name__).splitlines()[0]
        raise CasaError(f"{path}: cannot be read ({why}); draw the states again with --force") from error


def read_current_states(folder: Path, scene: Path) -> StartStates:
    """The start states in the folder of a scene. Raises CasaError where its file is missing or another than theirs."""
    found, path = read_states(folder), folder / START_STATES
    if not scene.is_file():
        raise CasaError(f"{scene}: is missing beside {path.name}; build the scene again")
    if digest_of_file(scene) != found.scene_xml:
        raise CasaError(
            f"{path}: the states were drawn for another {scene.name} than stands beside them; draw them again with "
            f"casa-assets scenes states {folder.name} --out {shlex.quote(str(folder.parent))}"
        )
    return found


def digest_of_file(path: Path) -> str:
    """sha256 of the bytes of a file, as start states name the scene.xml that they belong to."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
