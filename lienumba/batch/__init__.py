"""Runs in lanes, lanes in blocks, blocks in chunks, chunks on threads."""
