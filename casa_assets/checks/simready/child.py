"""Program that another Python runs to validate a USD file; `validator.py` starts it.

It needs SimReady's packages, usd-core and numpy in that Python, and nothing else that this package depends on.

    python -I child.py versions              prints {name: version} of the packages that decide a verdict
    python -I child.py FILE [CODE...]        prints {"verdict": [passed, {code: message}]}, where CODEs are requirements
                                             that need not be run; {"verdict": null} where SimReady gives no verdict;
                                             {"missing": reason} where its packages cannot be imported
"""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

DECIDING = ("simready-validate", "simready-foundation-tier-core", "usd-validation-nvidia", "usd-core")


def versions() -> dict[str, str]:
    """Versions of the packages that decide a verdict, by name, without those that are not installed."""
    found = {}
    for name in DECIDING:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _answer(path: str, without: list[str]) -> dict[str, object]:
    try:
        from casa_assets.checks.simready import rules

        rules.load_rules()
    except ImportError as error:
        return {"missing": str(error)}
    return {"verdict": rules.validate(Path(path), frozenset(without))}


def _find_own_package() -> None:
    """Make casa_assets importable without its folder's neighbours, packages that were built for another Python."""
    place = Path(__file__).parents[2]
    spec = importlib.util.spec_from_file_location(
        place.name, place / "__init__.py", submodule_search_locations=[str(place)]
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[place.name] = module
    spec.loader.exec_module(module)


def _main(arguments: list[str]) -> None:
    # Libraries print to standard output, which is kept for the answer.
    answers = os.dup(1)
    os.dup2(2, 1)
    if arguments == ["versions"]:
        answer: object = versions()
    else:
        _find_own_package()
        answer = _answer(arguments[0], arguments[1:])
    with os.fdopen(answers, "w", encoding="utf-8") as stream:
        json.dump(answer, stream)


if __name__ == "__main__":
    _main(sys.argv[1:])
