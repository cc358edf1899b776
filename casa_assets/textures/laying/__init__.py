"""How pieces are laid side by side: bonds of bricks, tiles, planks and stones that close over the border."""
