"""Driven motion, position by position, and the forces that go with it."""
