"""Light of a room: what a camera sees is drawn by MuJoCo as surfaces, and lit here from many directions."""
