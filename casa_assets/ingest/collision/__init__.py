"""Collision shapes of an ingested mesh: several strategies, tried in turn and measured against the solid."""
