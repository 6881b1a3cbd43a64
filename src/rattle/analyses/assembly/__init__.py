"""Assembly of a mechanism, its rank and its loops."""
