"""Routines: loops over rows of lanes, written as plain functions of Python, become LLVM text without Numba.

A small language, the one that Numba would compile as well: whole numbers, floats, lanes, masks, named tuples, arrays
of float64 and int64; loops, branches, calls. What is not of it is an error with the line that says it.
"""
