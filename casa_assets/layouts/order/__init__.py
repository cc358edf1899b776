"""What a kitchen needs built: cabinets, worktops, trim, room shell and props, each with its place."""
