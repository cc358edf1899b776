"""Settings of all tests: no example of hypothesis is judged by the clock, and every run tries the same ones."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("same_examples", deadline=None, derandomize=True)
settings.load_profile("same_examples")
