"""Drawings of mechanisms as primitives: written once, played by matplotlib, by the canvas of pages and as SVG."""
