"""What mechanisms are made of: joints, forces, quantities, laws of one's own."""
