"""Laws written by users in Python: loads, normal forces, friction."""
