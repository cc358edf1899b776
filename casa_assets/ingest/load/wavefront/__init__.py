"""Reader of Wavefront OBJ and MTL files."""
