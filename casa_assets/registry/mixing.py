"""registry/mixing.yaml: what is drawn together where kitchens are drawn at random."""

from __future__ import annotations

from casa_assets.model.kitchen.mixing import Mixing
from casa_assets.projects import read_once
from casa_assets.registry import read_record
from casa_assets.registry.kitchens import load_style, style_names
from casa_assets.registry.layered import read_table_file

FILE = "mixing.yaml"


@read_once
def load_mixing() -> Mixing:
    """The rules. Raises RegistryError where the file is wrong, or names a role that no style has."""
    document = read_table_file(FILE)
    mixing = read_record(Mixing, document.value, document, ())
    known = {role for name in style_names() for role in load_style(name)[0].models}
    for suite, roles in mixing.suites.items():
        for i, role in enumerate(roles):
            if role not in known:
                raise document.fault(("suites", suite, i), "a role of the styles", repr(role))
    return mixing
