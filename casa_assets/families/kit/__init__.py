"""What families are built with: solids, their skins, and the bench on which they become links and joints."""
