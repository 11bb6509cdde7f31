"""What every scheme is judged by: exact solutions and periods, by independent routes."""
