"""Tell one object from several things, a scene, a figure or a part; and take a file apart into its things."""
