"""What is wrong with what changes a mechanism: limits, contacts, what events do."""
