"""NVIDIA's SimReady validator: where it is installed, how it is called, and what makes it fast enough."""
