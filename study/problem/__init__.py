"""What is solved: the equation of motion with its mass, damping, force and load, and the named problems."""
