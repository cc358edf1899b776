"""Plan geometry: walls of the room, runs along them, slots of units in metres."""
