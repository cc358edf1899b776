"""List what a kitchen needs built: cabinets, worktops, trim, room shell and furnishings, each with its place."""
