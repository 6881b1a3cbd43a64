"""Contact laws, and the contact models besides the compliant ones."""
