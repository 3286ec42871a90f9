"""URDF: what a file says, whether it is a tree of bodies that can move, and MuJoCo's model of it."""
