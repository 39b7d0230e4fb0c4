"""What the sources printed, recomputed side by side with what is true."""
