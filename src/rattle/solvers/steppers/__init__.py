"""One explicit method of integration in each file: its step and its dense output."""
