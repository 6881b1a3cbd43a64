"""Loads: one kind per file, each a force or moment on one body or between two bodies."""
