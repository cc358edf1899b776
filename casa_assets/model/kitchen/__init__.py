"""Records of kitchens: floor plans, styles, what they are filled with, and the resolved scene."""
