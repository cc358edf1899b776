"""Parts of cooktops: burners and grates."""
