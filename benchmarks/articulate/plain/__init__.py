"""Things drawn out of plain solids, each with its moving parts labelled: what a modeller without joints would leave."""
