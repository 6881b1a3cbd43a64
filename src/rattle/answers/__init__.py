"""What questions answer: blocks of words, tables, curves, bars and pictures, and everything that shows them."""
