"""Family run: presets and draws into entries of a library."""
