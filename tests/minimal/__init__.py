"""An arm and its drivers against minimal coordinates."""
