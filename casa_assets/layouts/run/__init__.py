"""Kitchen run: resolve, build, write, check, compare and load scenes."""
