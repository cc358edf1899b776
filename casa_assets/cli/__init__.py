"""The command line: Typer verbs, one thin file each."""
