"""The compiler, from symbols to machine code."""
