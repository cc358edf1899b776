"""What is found in cases of the articulation benchmark, and how score.py grades it."""
