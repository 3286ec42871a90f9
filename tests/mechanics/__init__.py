"""The mechanics, against the paper, dense solvers and conservation laws."""
