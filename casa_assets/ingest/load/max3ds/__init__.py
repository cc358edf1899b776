"""3DS (3D Studio) -> RawModel. Ref: the 3D Studio file format, as published with 3D Studio R4."""
