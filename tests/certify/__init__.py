"""The proofs that a release needs beyond CI, see __main__.py."""
