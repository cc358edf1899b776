"""GLB and glTF 2.0 -> RawModel. Ref: Khronos glTF 2.0 specification."""
