"""Names, places and regions that runtimes expect of an articulated appliance."""
