"""How what a mechanism does changes with its inputs."""
