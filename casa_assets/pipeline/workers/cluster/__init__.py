"""Run jobs on a Ray cluster, with the limits and the isolation of the local pool."""
