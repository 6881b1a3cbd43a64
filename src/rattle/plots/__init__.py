"""Pictures, pages and films."""
