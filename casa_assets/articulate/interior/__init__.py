"""Behind fronts: cavities that the mesh has or that are built, lids, racks, drawer boxes, regions and burners."""
