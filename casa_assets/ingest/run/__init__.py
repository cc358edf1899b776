"""Ingest run: discover inputs, survey, run the stages in workers, publish."""
