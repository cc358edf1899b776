"""A folder of pictures by a text-to-image model into a pack: checked, made to tile, with derived relief and gloss."""
