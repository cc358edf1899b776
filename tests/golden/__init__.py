"""The golden set: digests of everything that the program writes for a fixed set of inputs."""
