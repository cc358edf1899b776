"""ATTRIBUTION.md of a library, an export or a pack: who made what, under which licence."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

from casa_assets.core.system import replace_file
from casa_assets.library.entry import Entry
from casa_assets.library.library import Library
from casa_assets.model.kitchen.scene import Scene

NAME = "ATTRIBUTION.md"
# Of one field; what is longer is no name of a thing, a person or a licence.
MAX_CHARACTERS = 300
# What Markdown may show as a link; another address is only text.
_WEB_ADDRESS = re.compile(r"https?://[A-Za-z0-9.-]+(:[0-9]+)?(/[A-Za-z0-9._~/%?=+,;:@-]*)?")


@dataclass(frozen=True)
class Credit:
    """Attribution of one asset, as its provenance states it, with the digest of its source; empty: not stated."""

    id: str
    licence: str
    title: str = ""
    author: str = ""
    uri: str = ""
    generator: str = ""
    sha256: str = ""


def write(library: Library, found: Iterable[Entry]) -> None:
    """Write the whole file from the entries, replacing it by one rename."""
    replace_file(library.root / NAME, text([entry for entry in found if entry.accepted]).encode())


def text(accepted: list[Entry]) -> str:
    """Markdown: one section per licence, one line per asset with title, author, source and digest."""
    lines = ["# Attribution", "", f"{len(accepted)} assets. Changes made to all of them: cleaned, oriented, scaled to"]
    lines += ["metres, simplified where large, given collision shapes, mass and labels; written as MJCF and USD.", ""]
    found = (
        Credit(e.id, e.licence, e.title or e.source_path.rsplit("/", 1)[-1], e.author, e.uri, e.generator, e.sha256)
        for e in accepted
    )
    return "\n".join([*lines, *_by_licence(found)])


def kitchens_text(kitchens: Collection[str], found: Iterable[Credit]) -> str:
    """Markdown: what kitchens consist of, one section per licence, one line per asset, however often it is found."""
    once = {credit.id: credit for credit in found}
    names = ", ".join(f"`{_in_code(name)}`" for name in sorted(kitchens))
    lines = ["# Attribution of the kitchens", "", f"{len(once)} assets, of which these kitchens consist: {names}.", ""]
    return "\n".join([*lines, *_by_licence(once.values())])


def credits_of(scene: Scene) -> tuple[Credit, ...]:
    """One credit for each asset of a kitchen, in their order."""
    return tuple(
        Credit(asset.id, said.licence, said.title, said.author, said.uri, said.generator)
        for asset in scene.assets
        for said in (asset.provenance,)
    )


def _by_licence(found: Iterable[Credit]) -> Iterator[str]:
    """Yield lines: a section for each licence, with its assets in the order of their ids."""
    by_licence: dict[str, list[Credit]] = defaultdict(list)
    for credit in found:
        by_licence[credit.licence].append(credit)
    for licence in sorted(by_licence):
        yield from (f"## {escaped(licence)}", "")
        if licence == "unknown":
            yield from ("The source states no licence; do not pass these on before you have asked.", "")
        yield from (_line(c) for c in sorted(by_licence[licence], key=lambda c: c.id))
        yield ""


def _line(credit: Credit) -> str:
    title = f": {escaped(credit.title)}" if credit.title else ""
    author = f" by {escaped(credit.author)}" if credit.author else ""
    made = f", made with {escaped(credit.generator)}" if credit.generator else ""
    address = credit.uri if _WEB_ADDRESS.fullmatch(credit.uri) else escaped(credit.uri)
    uri = f", {address}" if credit.uri else ""
    source = f" (source sha256 {_in_code(credit.sha256[:12])})" if credit.sha256 else ""
    return f"- `{_in_code(credit.id)}`{title}{author}{made}{uri}{source}"


def escaped(words: str) -> str:
    """Words of strangers as Markdown that shows them, on one line, with no markup, picture or link of theirs.

    Ref: CommonMark 0.31, backslash escapes; GFM, autolinks (extension), which take bare `https://`, `www.` and `a@b`.
    """
    plain = _one_line(words)
    plain = re.sub(r"([\\`*_\[\]<>|~&!#@])", r"\\\1", plain)
    return re.sub(r"(?i)\b(www)\.", r"\1\.", plain.replace("://", "\\://"))


def _in_code(words: str) -> str:
    """Words inside backticks, which nothing but a backtick ends."""
    return _one_line(words).replace("`", "'")


def _one_line(words: str) -> str:
    text = " ".join("".join(c if c.isprintable() else " " for c in words).split())
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]} ..."
