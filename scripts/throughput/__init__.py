"""How much of the cores goes into integrating where results are stored."""
