"""An independent code to compare random mechanisms with: NumPy and SciPy, small and slow, no line of the package."""
