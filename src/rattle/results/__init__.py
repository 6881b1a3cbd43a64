"""What a run leaves behind: numbers with names and units, and how far to trust them."""
