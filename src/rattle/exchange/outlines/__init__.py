"""Drawings of parts: closed lines of straight edges and arcs, and the mechanism that layers of them are."""
