"""Search over frames, ways of splitting and kinds for the plan that is most probably right."""
