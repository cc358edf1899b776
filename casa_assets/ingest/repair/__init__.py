"""What `clean` mends: one fault to a module, each with the note that it leaves."""
