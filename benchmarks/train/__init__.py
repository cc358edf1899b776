"""Scripts that fit what `articulate` has learned on labelled cases and write it into registry/."""
