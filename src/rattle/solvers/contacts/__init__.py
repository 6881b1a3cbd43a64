"""Contacts inside a step: when they start and end, whether one has been missed, what is kept of them."""
