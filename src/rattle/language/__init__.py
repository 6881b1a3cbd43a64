"""The content of quoted values in a model file: units, expressions, materials."""
