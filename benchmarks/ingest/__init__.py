"""What `casa-assets ingest` makes of meshes: shapes, poses, repairs, duplicates, and what it costs."""
