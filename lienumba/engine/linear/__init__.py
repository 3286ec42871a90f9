"""Linearised equations of motion: of every run, at any of its times."""
