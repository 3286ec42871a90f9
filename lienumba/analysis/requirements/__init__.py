"""Whether runs do what they shall, and what sets apart those that do not."""
