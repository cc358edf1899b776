"""The program that Blender's own Python runs; nothing of it is imported by this package."""
