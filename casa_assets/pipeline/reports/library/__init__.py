"""The report on a library: page, JSON, comparison with an earlier run, conditions that fail a build."""
