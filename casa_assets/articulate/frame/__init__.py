"""Frame of an appliance mesh: which way is up, where the front is, how long a unit is, what kind it is."""
