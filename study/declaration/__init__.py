"""How experiments declare what they make, read and ask for."""
