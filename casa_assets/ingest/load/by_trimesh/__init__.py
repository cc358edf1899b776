"""Formats that trimesh reads for us (OFF, 3MF, XAML), and trimesh objects in memory, bounded before and after."""
