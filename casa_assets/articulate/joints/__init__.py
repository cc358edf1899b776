"""Joints of moving parts: hinges, slides, lids, their axes and ranges, friction and damping."""
