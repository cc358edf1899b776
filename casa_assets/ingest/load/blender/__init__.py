"""Blender files -> RawModel, by Blender in a process of its own."""
