"""What can be asked of a mechanism."""
