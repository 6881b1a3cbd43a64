"""Mechanisms drawn by hand: what a model text looks like, and what every act of drawing changes in it."""
