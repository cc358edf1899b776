"""Kit of the families: solids with colliders, and the builder that makes links, joints and an Asset of them."""
