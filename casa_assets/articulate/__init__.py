"""One static mesh of an appliance or cabinet -> its moving parts, their joints, and an Asset that opens."""
