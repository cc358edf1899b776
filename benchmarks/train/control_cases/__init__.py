"""Controls to learn from: drawn scenes, and what is measured of the controls of scenes and of benchmark cases."""
