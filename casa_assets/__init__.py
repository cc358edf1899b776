"""Raw meshes, appliance models and declarative kitchens into simulation-ready MJCF and USD."""

__version__ = "0.1.0"
