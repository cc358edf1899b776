"""Pose of a mesh: candidates for up, evidence for each, and the front."""
