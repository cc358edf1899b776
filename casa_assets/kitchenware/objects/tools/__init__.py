"""Cutlery, cooking utensils and small tools: a handle and a head."""
