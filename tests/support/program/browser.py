"""A real, headless Chromium for tests, see `./dev consumers`: opens a page, uses it, says what it logged."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
HOME = ROOT / os.environ.get("CASA_BROWSER", ".venv-browser")
DRIVER = ROOT / "tests" / "consumers" / "browser_driver.py"
PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "chrome")
LOCAL = ("file:", "blob:", "data:", "about:")


class Browser:
    def __init__(self) -> None:
        program = next((path for name in PROGRAMS if (path := shutil.which(name))), None)
        assert program is not None, "Chromium is needed: sudo apt-get install chromium"
        axe = HOME / "node" / "node_modules" / "axe-core" / "axe.min.js"
        assert axe.is_file(), f"{axe} is missing: ./dev consumers installs it"
        command = [str(HOME / "bin" / "python"), str(DRIVER), program, str(axe)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, do: str, *words: Any) -> Any:
        """What a method of the driver returns. Raises AssertionError with what Playwright says where it fails."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps([do, *words]) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, f"the browser ended during {do!r}, code {self._process.poll()}"
        answer = json.loads(line)
        assert "error" not in answer, f"{do} {words}: {answer['error']}"
        return answer["value"]

    def open(
        self, page: Path | str, width: int = 1280, height: int = 800, dark: bool = False, touch: bool = False
    ) -> Page:
        """Open a file or an address; the page that was open before is gone."""
        url = page.absolute().as_uri() if isinstance(page, Path) else page
        self.ask("open", url, width, height, dark, touch)
        return Page(self, url)

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(timeout=30)


@dataclass(frozen=True)
class Page:
    """The page that is open. Selectors are those of Playwright: CSS, `text=Open`, `role=button[name="Open"]`."""

    browser: Browser
    url: str

    def __getattr__(self, do: str) -> Callable[..., Any]:
        """A method of the driver: `click`, `fill`, `press`, `wait`, `evaluate` and the others of browser_driver.py."""
        return partial(self.browser.ask, do)

    def texts(self, selector: str) -> list[str]:
        found: list[str] = self.evaluate(
            f"[...document.querySelectorAll({json.dumps(selector)})].filter(e => e.checkVisibility())"
            ".map(e => e.textContent.trim())"
        )
        return found

    @property
    def fits(self) -> bool:
        return bool(self.evaluate("document.documentElement.scrollWidth <= innerWidth"))

    def assert_clean(self, is_accessible: bool = True) -> None:
        """No error or warning on the console, no request to another machine, nothing serious found by axe-core."""
        found = self.browser.ask("told")
        own = self.url.split("/", 3)[:3]
        strange = [url for url in found["requests"] if not url.startswith(LOCAL) and url.split("/", 3)[:3] != own]
        assert (found["errors"], strange) == ([], [])
        assert not is_accessible or self.violations() == []
