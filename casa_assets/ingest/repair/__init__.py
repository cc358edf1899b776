"""Repairs of the stage `clean`: one kind of fault to a module, each with the note that it leaves."""
