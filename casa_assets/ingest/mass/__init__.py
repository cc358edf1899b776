"""Mass and inertia of an ingested mesh: several estimates, and one result of them."""
