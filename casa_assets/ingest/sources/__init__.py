"""Sources of raw meshes: folders, Objaverse packages, text-to-3D deliveries, plain manifests."""
