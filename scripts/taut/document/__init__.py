"""What of the documents is made by programs."""
