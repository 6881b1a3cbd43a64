"""Pictures, pages and animations."""
