"""The door: Typer verbs, one file each, thin."""
