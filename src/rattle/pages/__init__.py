"""Self-contained web pages: motion that one can play, turn and send."""
