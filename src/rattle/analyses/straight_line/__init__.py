"""A model as straight-line code: recorded once, then integrated for many samples, differentiated, or written out."""
