"""Records of kitchens: floor plans, styles, contents, and the resolved scene."""
