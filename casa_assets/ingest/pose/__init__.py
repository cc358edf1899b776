"""How a thing rests and which way it looks: candidates, evidence, front."""
