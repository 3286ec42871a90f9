"""What it takes to reach an error: this engine's methods beside heyoka, on the same mechanisms."""
