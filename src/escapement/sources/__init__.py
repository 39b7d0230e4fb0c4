"""What four papers printed, recomputed side by side with what is true."""
