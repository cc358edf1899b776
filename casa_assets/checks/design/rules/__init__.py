"""Guidelines of kitchen design as checks: doorways, aisles, landing areas, heights, the work triangle."""
