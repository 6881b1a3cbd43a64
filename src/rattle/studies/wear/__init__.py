"""Wear of pins and bushes over many cycles."""
