"""What `casa-assets articulate` finds and costs, and how the cases that tell are made."""
