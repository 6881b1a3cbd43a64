"""What play does to accuracy."""
