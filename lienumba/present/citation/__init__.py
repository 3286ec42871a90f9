"""What a publication says of a simulation: a paragraph for its section on methods, and the references of that."""
