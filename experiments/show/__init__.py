"""What people see: the terminal, pictures and recordings."""
