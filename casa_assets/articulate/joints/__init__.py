"""Joint of each moving part: hinge, slide or lid, its axis and range, friction and damping."""
