"""Of what tables of runs consist."""
