"""The model file and the frozen model."""
