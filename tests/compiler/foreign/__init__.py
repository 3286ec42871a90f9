"""Tests of lienumba/compiler/foreign."""
