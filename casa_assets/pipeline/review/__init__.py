"""Review: a page on which a person decides about assets that were told on thin evidence."""
