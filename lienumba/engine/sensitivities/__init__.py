"""The derivative of every run by its inputs."""
