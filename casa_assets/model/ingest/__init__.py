"""Records of what comes in: source, bundle, raw model, and what a user overrides."""
