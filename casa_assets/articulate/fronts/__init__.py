"""Doors, flaps and drawer fronts: flat panels on the sides of a mesh, merged into what moves as one."""
