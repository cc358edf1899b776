"""Labelled cases of the articulation benchmark's form: read, changed, drawn and written."""
