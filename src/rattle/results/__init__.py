"""Results of an analysis: numbers with names and units, and how far to trust them."""
