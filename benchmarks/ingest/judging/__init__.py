"""What the benchmarks measure with: the same ruler for every tool."""
