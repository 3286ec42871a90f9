"""An attack on the scenario language: scenarios made of its schema and of the gallery, and broken in many ways."""
