"""Meshes: read from files, simplified, packed into text."""
