"""What people see: pictures, pages, terminal, citations."""
