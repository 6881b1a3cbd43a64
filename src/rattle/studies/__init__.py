"""What runs a mechanism many times."""
