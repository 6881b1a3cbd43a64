"""What may stand in quotes in a model file: units, expressions, materials."""
